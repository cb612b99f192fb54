"""The one door for text that users give: regular, bounded, decoded, not too deep."""

import os
import socket
from pathlib import Path

import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.core.user_files import MOST_BYTES, MOST_DEPTH, json_document, read_bytes, read_text, toml


def test_text_comes_with_the_line_ends_of_this_program_and_without_a_byte_order_mark(tmp_path):
    file = tmp_path / "a.toml"
    file.write_bytes(b'\xef\xbb\xbfa = 1\r\nb = "\xc2\xb0"\r\n')
    assert read_text(file, "the file") == 'a = 1\nb = "°"\n'
    assert read_text(file, "the file", keep_line_ends=True) == 'a = 1\r\nb = "°"\r\n'


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"a = 1\n# caf\xe9", "not UTF-8 text in line 2"), ("a = 1".encode("utf-16"), "not UTF-8 text in line 1")],
)
def test_what_is_not_utf_8_is_refused_with_its_line(tmp_path, content, words):
    (tmp_path / "a.toml").write_bytes(content)
    with pytest.raises(ParameterError, match=f"the map .*a.toml cannot be read .*{words}.*; save it as UTF-8"):
        read_text(tmp_path / "a.toml", "the map", ParameterError)


def test_a_pipe_a_socket_a_device_and_a_folder_are_refused_before_they_are_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(tmp_path / "socket"))
        for path, words in (
            (tmp_path / "pipe", "a pipe"),
            (tmp_path / "socket", "a socket"),
            (Path("/dev/zero"), "a device"),
            (Path("/dev/null"), "a device"),
            (tmp_path, "a folder"),
            (tmp_path / "none", "no such file"),
            (tmp_path / "a\0b", "null"),
            (tmp_path / ("a" * 300), "too long"),
            (Path("~no-such-user-here/a"), "no such file"),
        ):
            with pytest.raises(InputError, match=f"the map .* cannot be read .*{words}.*; give another"):
                read_bytes(path, "the map", cure="give another")


def test_a_pipe_that_takes_the_place_of_a_file_is_not_waited_for(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    regular = (tmp_path / "regular").touch() or os.stat(tmp_path / "regular")
    monkeypatch.setattr("tierod.core.user_files.os.stat", lambda path: regular)
    with pytest.raises(InputError, match="a pipe"):
        read_bytes(tmp_path / "pipe", "the map")


def test_a_file_is_no_longer_than_allowed(tmp_path):
    with (tmp_path / "large").open("wb") as file:
        file.truncate(MOST_BYTES)
    assert len(read_bytes(tmp_path / "large", "the map")) == MOST_BYTES
    with (tmp_path / "large").open("wb") as file:
        file.truncate(100 * MOST_BYTES)
    with pytest.raises(InputError, match="the map .*large is longer than 1 MiB"):
        read_bytes(tmp_path / "large", "the map")
    with pytest.raises(InputError, match="longer than 10 bytes"):
        read_bytes("/proc/self/status", "the map", most=10)


@pytest.mark.parametrize(
    "text",
    [
        "a = " + 1000 * "[" + 1000 * "]",
        "a = " + 200_000 * "[",
        "a = " + 1000 * "{a = " + "1" + 1000 * "}",
        "a" + 50_000 * ".a" + " = 1",
        "a" + 50_000 * ' . "a.a"' + " = 1",
        "[" + 50_000 * "a." + "a]",
        "[[" + 50_000 * "'a'." + "a]]",
        "b = {" + 50_000 * "a." + "a = 1}",
        "b = [{c = 1, " + 50_000 * "a." + "a = 1}]",
        "\n".join(f"[{'.'.join(['a'] * depth)}]" for depth in range(1, MOST_DEPTH + 3)),
    ],
)
def test_toml_is_not_nested_deeply(text):
    with pytest.raises(ParameterError, match="here.toml.*more than 32 levels"):
        toml(text, "here.toml", ParameterError)


@pytest.mark.parametrize("text", ["a = " + 10_000 * "9", "a = 1 2", "a = \x1b", "a = 1\ra = 2"])
def test_what_is_no_toml_is_refused(text):
    with pytest.raises(InputError, match="here.toml is not valid TOML: .*; correct it there"):
        toml(text, "here.toml")


def test_dots_in_texts_and_remarks_are_no_levels():
    dotted = ".".join(["a"] * 100)
    assert toml(f'a = "{dotted}" # {dotted}', "here") == {"a": dotted}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (1000 * "[" + 1000 * "]", "more than 32 levels"),
        (500_000 * "[", "more than 32 levels"),
        (1000 * '{"a":' + "1" + 1000 * "}", "more than 32 levels"),
        ("{", "not JSON from line 1 on"),
        (b"\xff", "not UTF-8"),
        (r'{"a": "\ud800"}', "half of a character"),
        (r'{"\uDC00": 1}', "half of a character"),
        (10_000 * "9", "digits"),
    ],
)
def test_json_that_is_refused(text, words):
    with pytest.raises(ValueError, match=words):
        json_document(text)


def test_json_of_whole_characters_is_read():
    assert json_document(b'\xef\xbb\xbf{"a": ["\\ud83d\\ude97", 1.5, null]}') == {"a": ["🚗", 1.5, None]}
