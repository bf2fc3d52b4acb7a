import csv
import hashlib
import math
import subprocess
import sys
import zipfile

import pytest

import packages
import shapes
from packages import Model, Package, Problem, catalogue, download, notice_of, notices

COPYRIGHT = """Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/

Files: *
Copyright: 2020, Everyone
License: CC0

Files: cups/a*
 cups/b.obj
Copyright: 2021, Someone
License: GPL-3+
Comment: auto generated

License: GPL-3+
 The text of the licence.
"""


def obj(n, height):
    """A prism of n sides."""
    turn = 2 * math.pi / n
    lines = [f"v {math.cos(turn * i)} {y} {math.sin(turn * i)}" for y in (0, height) for i in range(n)]
    lines.append("f " + " ".join(str(i + 1) for i in range(n)))
    lines.append("f " + " ".join(str(i + n + 1) for i in reversed(range(n))))
    lines += [f"f {i + 1} {i + n + 1} {(i + 1) % n + n + 1} {(i + 1) % n + 1}" for i in range(n)]
    return "\n".join(lines)


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of four prisms, one flat and one without a free licence, in place of the true packages."""
    folder = tmp_path / "packages"
    folder.mkdir()
    with zipfile.ZipFile(folder / "prisms.whl", "w") as archive:
        for name, height in [("tall", 1.5), ("taller", 2), ("flat", 0.1), ("secret", 1)]:
            archive.writestr(f"prisms/{name}.obj", obj(40, height))
        archive.writestr("prisms/code.py", "")
    sha256 = hashlib.sha256((folder / "prisms.whl").read_bytes()).hexdigest()
    package = Package("PyPI", "prisms", "1.0", "prisms.whl", sha256)

    def models(package, unpacked):
        for path in sorted(unpacked.rglob("*.obj")):
            licence = "ask first" if path.stem == "secret" else "CC0"
            source = path.relative_to(unpacked).as_posix()
            yield Model(package, source, "prism", licence, "Euclid", source, path.stem, path.read_bytes, 0.5)

    monkeypatch.setattr(shapes, "PACKAGES", {package: ((".obj",), models)})
    return package, folder


def run(*arguments, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["shapes.py", *map(str, arguments)])
    shapes.main()


def test_the_same_command_writes_the_same_bytes(package, tmp_path, monkeypatch, capsys):
    for name in ("one", "two"):
        run(tmp_path / name, "--packages", package[1], "--count", 9, monkeypatch=monkeypatch)
    one, two = (
        {path.relative_to(tmp_path / name): path.read_bytes() for path in (tmp_path / name).rglob("*.*")}
        for name in ("one", "two")
    )
    assert one == two
    assert len(one) == 4
    rows = list(csv.DictReader(open(tmp_path / "one/manifest.csv")))
    assert [row["family"] for row in rows] == ["tall", "taller"]
    assert float(rows[1]["extent_z_m"]) == pytest.approx(0.5)
    mesh = (tmp_path / "one/meshes" / rows[0]["mesh"]).read_bytes()
    assert rows[0]["mesh_sha256"] == hashlib.sha256(mesh).hexdigest()
    results = {row["source"]: row["result"] for row in csv.DictReader(open(tmp_path / "one/models.csv"))}
    assert (results["prisms/flat.obj"], results["prisms/secret.obj"]) == ("flat", "licence")
    manifest = hashlib.sha256((tmp_path / "two/manifest.csv").read_bytes()).hexdigest()
    assert capsys.readouterr().out.endswith(f"manifest {manifest}\n")


def test_a_difference_from_the_expected_manifest_ends_with_an_error(package, tmp_path, monkeypatch):
    monkeypatch.setattr(shapes, "EXPECTED", tmp_path / "manifest.csv")
    run(tmp_path / "one", "--packages", package[1], "--count", 9, monkeypatch=monkeypatch)
    text = (tmp_path / "one/manifest.csv").read_text()
    (tmp_path / "manifest.csv").write_text(text)
    run(tmp_path / "two", "--packages", package[1], monkeypatch=monkeypatch)
    (tmp_path / "manifest.csv").write_text(text.replace("Euclid", "Thales", 1))
    with pytest.raises(SystemExit, match="1 lines are missing and 1 are new"):
        run(tmp_path / "three", "--packages", package[1], monkeypatch=monkeypatch)


def test_a_folder_that_is_not_empty_stays_as_it_is(package, tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/mine").write_text("")
    with pytest.raises(SystemExit, match="not empty"):
        run(tmp_path / "out", "--packages", package[1], monkeypatch=monkeypatch)
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["mine"]


def test_another_package_than_the_pinned_one_leaves_nothing(package, tmp_path, monkeypatch):
    (package[1] / "prisms.whl").write_bytes(b"other")
    with pytest.raises(SystemExit, match="package prisms 1.0 .PyPI.: .* has the SHA-256"):
        run(tmp_path / "out", "--packages", package[1], monkeypatch=monkeypatch)
    assert [path.name for path in tmp_path.iterdir()] == ["packages"]


def test_a_download_that_fails_names_the_package(tmp_path, monkeypatch):
    failed = subprocess.CompletedProcess([], 100, "", "E: Unable to locate package cups\n")
    monkeypatch.setattr(packages.subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(Problem, match="package cups 1.0 .Debian. was not downloaded: E: Unable to locate"):
        download(Package("Debian", "cups", "1.0", "cups_1.0_all.deb", ""), tmp_path)


@pytest.mark.parametrize(
    ("path", "licence", "author"),
    [
        ("plate.obj", "CC0", "2020, Everyone"),
        ("cups/ab/c.obj", "GPL-3+", "2021, Someone"),
        ("cups/b.obj", "GPL-3+", "2021, Someone"),
    ],
)
def test_the_last_notice_counts(path, licence, author):
    notice = notice_of(path, notices(COPYRIGHT))
    assert (notice.licence, notice.author) == (licence, author)


def test_a_catalogue_has_a_table_for_each_model():
    text = "version=1.8\nmodel#2=/b.obj\nmodel#1=/a.obj\nwidth#1 = 7.5\n"
    assert catalogue(text) == [{"model": "/a.obj", "width": "7.5"}, {"model": "/b.obj"}]


def test_the_pinned_manifest_is_whole():
    rows = list(csv.DictReader(open(shapes.EXPECTED)))
    assert len(rows) == shapes.DEFAULT_COUNT
    assert {row["licence"] for row in rows} <= shapes.LICENCES
    parts = {}
    assert all(parts.setdefault(row["family"], row["part"]) == row["part"] for row in rows)
    pinned = {(package.name, package.version) for package in packages.PACKAGES}
    assert {(row["package"], row["version"]) for row in rows} == pinned
