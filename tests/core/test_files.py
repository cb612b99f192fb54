import errno
import os
import stat

import pytest

from tierod.core.errors import OutputError
from tierod.core.files import replacing, require_folder, write_text


def half_write(target, error):
    with replacing(target) as temporary:
        temporary.write_text("half")
        raise error


def test_writes_and_replaces(tmp_path):
    target = tmp_path / "out.txt"
    write_text(target, "old")
    write_text(target, "näw")
    assert target.read_text(encoding="utf-8") == "näw"
    assert [path.name for path in tmp_path.iterdir()] == ["out.txt"]


def test_gives_the_rights_of_any_new_file(tmp_path):
    write_text(tmp_path / "ours", "")
    (tmp_path / "theirs").write_text("")
    assert stat.S_IMODE((tmp_path / "ours").stat().st_mode) == stat.S_IMODE((tmp_path / "theirs").stat().st_mode)


@pytest.mark.parametrize(
    ("number", "remedy"),
    [(errno.ENOSPC, "make room on the disk"), (errno.EIO, "check the disk"), (errno.EROFS, "name a place")],
)
def test_leaves_the_old_file_when_writing_fails(tmp_path, number, remedy):
    target = tmp_path / "out.txt"
    target.write_text("old")
    with pytest.raises(OutputError, match=remedy):
        half_write(target, OSError(number, os.strerror(number)))
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out.txt"]


def test_leaves_nothing_when_interrupted(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        half_write(tmp_path / "out.txt", KeyboardInterrupt())
    assert not list(tmp_path.iterdir())


def test_a_folder_is_no_target(tmp_path):
    with pytest.raises(OutputError, match="name a file, not a folder"):
        write_text(tmp_path, "text")


def test_an_absent_folder_is_named(tmp_path):
    with pytest.raises(OutputError, match="create the folder first"):
        write_text(tmp_path / "absent" / "out.txt", "text")


def test_a_pipe_is_never_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(OutputError, match="a device or a pipe"):
        write_text(pipe, "text")
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_a_link_stays_and_its_file_is_replaced(tmp_path):
    real, link = tmp_path / "folder" / "real.txt", tmp_path / "link.txt"
    real.parent.mkdir()
    real.write_text("old")
    link.symlink_to(real)
    write_text(link, "new")
    assert link.is_symlink()
    assert real.read_text() == "new"


def test_a_missing_folder_is_reported_of_beforehand(tmp_path):
    with pytest.raises(OutputError, match="there is no folder .*absent; create the folder first"):
        require_folder(tmp_path / "absent" / "page.html")
    require_folder(tmp_path / "page.html")


def test_what_a_killed_process_left_goes_after_an_hour_and_nothing_else(tmp_path):
    names = {".out.0123456789ab.txt": True, ".out.0123456789ab.html": False, ".outer.0123456789ab.txt": False,
             ".out.txt": False, ".out.0123456789abc.txt": False}  # fmt: skip
    for name in names:
        (tmp_path / name).write_text("half")
        os.utime(tmp_path / name, (0, 0))
    (tmp_path / ".out.ba9876543210.txt").write_text("just being written by another process")
    write_text(tmp_path / "out.txt", "text")
    gone = {name for name in names if not (tmp_path / name).exists()}
    assert gone == {name for name, ours in names.items() if ours}
    assert (tmp_path / ".out.ba9876543210.txt").exists()
