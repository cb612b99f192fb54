"""The modules of the first view in one file."""

import re
import shutil
import subprocess

import pytest

from tierod.web.bundle import IMPORT, bundled

MODULES = {
    "main.js": 'import { twice as double, LEAST } from "./parts.js";\nimport { Point } from "./door.js";\n'
    "console.log(double(LEAST), new Point(3).x);\n",
    "parts.js": 'import { Point } from "./door.js";\nexport const LEAST = 4;\n'
    "export function twice(value) { return 2 * new Point(value).x; }\n",
    "door.js": 'export { P as Point } from "./vendor/kept.js";\n',
    "vendor/kept.js": "class a{constructor(x){this.x=x}}const unused=1;export{a as P,unused as Q};",
    "late.js": 'import { LEAST, twice } from "./parts.js";\nconsole.log(twice(LEAST + 1));\n',
}


def test_what_is_needed_stands_before_what_needs_it():
    whole, stands = bundled(MODULES, "main.js", "first.js")
    places = [whole.index(f"const {name} =") for name in ("$kept", "$door", "$parts", "$main")]
    assert places == sorted(places)
    assert "late" not in whole
    assert set(stands) == {"parts.js", "door.js"}


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_it_does_what_the_modules_do(tmp_path):
    whole, stands = bundled(MODULES, "main.js", "first.js")
    (tmp_path / "package.json").write_text('{"type": "module"}')
    for name, text in {**stands, "first.js": whole, "late.js": MODULES["late.js"]}.items():
        (tmp_path / name).write_text(text)
    for entry, said in (("first.js", "8 3\n"), ("late.js", "8 3\n10\n")):
        done = subprocess.run(["node", tmp_path / entry], capture_output=True, text=True, check=True)
        assert done.stdout == said


@pytest.mark.parametrize("line", ["import x from './a.js';", "export default 3;", "export let changing = 1;"])
def test_another_form_is_refused(line):
    with pytest.raises(ValueError, match="in a form that is not expected"):
        bundled({"main.js": line}, "main.js", "first.js")


def test_every_view_imports_what_the_modules_of_the_page_give():
    pytest.importorskip("fastapi", reason="the extra 'web' is not installed")
    from tierod.web.page import STATIC, files

    for path in STATIC.glob("*.js"):
        for names, place in IMPORT.findall(path.read_text(encoding="utf-8")):
            given = files().content[place.removeprefix("./")].decode()
            for name in re.findall(r"(\w+)(?: as \w+)?(?:,|$)", names.strip()):
                assert re.search(rf"\b{name}\b", given), (path.name, place, name)
