"""The packages that shapes come from: downloading, unpacking, and what each says of its models."""

import hashlib
import re
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass
from fnmatch import translate
from functools import partial
from pathlib import PurePosixPath
from typing import Callable, Iterator, NamedTuple

import numpy as np

import meshes
import vrml
from choose import family, series
from meshes import Mesh

# VRML of KiCad counts in tenths of an inch.
KICAD_M = 0.00254


class Problem(Exception):
    """Ends the program: what is wrong, and a hint."""


@dataclass(frozen=True)
class Package:
    registry: str
    name: str
    version: str
    file: str
    sha256: str

    def __str__(self):
        return f"{self.name} {self.version} ({self.registry})"


@dataclass(frozen=True)
class Model:
    """A model of a package, not yet read."""

    package: Package
    # Path in the package; of a model in an archive in the package, the archive's name and the path there.
    source: str
    # Kind of thing, as the package sorts its models.
    category: str
    licence: str
    author: str
    # Models of one series differ in size alone.
    series: str
    family: str
    read: Callable[[], bytes]
    # What the longest side is known to be; without it, the file states metres or has a unit of its own.
    longest_side_m: float | None = None
    # Row by row, what the catalogue turns the model by.
    rotation: tuple[float, ...] = (1, 0, 0, 0, 1, 0, 0, 0, 1)

    def mesh(self, data):
        """The mesh of the model's bytes, in metres, z up."""
        kind = PurePosixPath(self.source).suffix.lower()
        if kind == ".wrl":
            mesh = vrml.read(data)
            return Mesh(mesh.vertices * KICAD_M, mesh.triangles)
        if kind == ".stl":
            return meshes.read_stl(data)
        mesh = meshes.read_obj(data)
        x, y, z = mesh.vertices.T
        rows = np.array(self.rotation).reshape(3, 3)
        x, y, z = (row[0] * x + row[1] * y + row[2] * z for row in rows)
        mesh.vertices = np.stack([x, -z, y], axis=1)
        longest = mesh.sides().max()
        if longest > 0:
            mesh.vertices *= self.longest_side_m / longest
        return mesh


class Notice(NamedTuple):
    """What a Debian package's file `copyright` says of some files."""

    is_for: re.Pattern
    licence: str
    author: str


def notices(text):
    """The notices of a file `copyright` in Debian's format 1.0, in their order."""
    found = []
    for stanza in re.split(r"\n[ \t]*\n", text):
        fields = dict(re.findall(r"^(\S+):[ \t]*((?:.*\n?)(?:[ \t].*\n?)*)", stanza, re.MULTILINE))
        if "Files" in fields:
            globs = "|".join(map(translate, fields["Files"].split()))
            licence, author = (fields.get(key, "").strip().split("\n")[0].strip() for key in ("License", "Copyright"))
            found.append(Notice(re.compile(globs), licence, author))
    return found


def notice_of(path, all_notices):
    """The notice of a file: the last that names it counts."""
    for notice in reversed(all_notices):
        if notice.is_for.match(path):
            return notice
    raise Problem(f"the file `copyright` says nothing of {path}")


def catalogue(text):
    """The models of a catalogue of Sweet Home 3D: a table for each, by key."""
    found = {}
    for line in text.splitlines():
        match = re.match(r"(\w+)#(\d+)\s*=\s*(.*)", line)
        if match:
            found.setdefault(int(match[2]), {})[match[1]] = match[3].strip()
    return [found[number] for number in sorted(found)]


def kicad(package, folder) -> Iterator[Model]:
    all_notices = notices((folder / f"usr/share/doc/{package.name}/copyright").read_text())
    root = folder / "usr/share/kicad/3dmodels"
    for path in sorted(root.rglob("*.wrl")):
        source = path.relative_to(root).as_posix()
        notice = notice_of(source, all_notices)
        category = path.parent.name.removesuffix(".3dshapes")
        yield Model(package, source, category, notice.licence, notice.author, series(path.stem), family(path.stem),
                    path.read_bytes)


def sweet_home(package, folder) -> Iterator[Model]:
    all_notices = notices((folder / f"usr/share/doc/{package.name}/copyright").read_text())
    for path in sorted((folder / "usr/share/sweethome3d/furniture").glob("*.sh3f")):
        archive = zipfile.ZipFile(path)
        text = archive.read("PluginFurnitureCatalog.properties").decode("latin-1")
        for item in sorted(catalogue(text), key=lambda item: item["model"]):
            source, name = path.stem + item["model"], PurePosixPath(item["model"]).stem
            yield Model(
                package, source, item["category"], notice_of(source, all_notices).licence, item["creator"],
                # A number tells one design from another here.
                source, family(name), partial(archive.read, item["model"].lstrip("/")),
                max(float(item[key]) for key in ("width", "depth", "height")) / 100,
                tuple(map(float, item.get("modelRotation", "1 0 0 0 1 0 0 0 1").split())),
            )


def dog(package, folder) -> Iterator[Model]:
    for path in sorted((folder / "dm_control/suite/dog_assets").glob("BONE*.stl")):
        source = path.relative_to(folder).as_posix()
        yield Model(package, source, "Bone", "Apache-2.0", "The dm_control Authors", source,
                    family(path.stem.removeprefix("BONE")), path.read_bytes)


# What is unpacked of a package, and what gives its models.
PACKAGES = {
    Package(
        "Debian", "kicad-packages3d", "6.0.10-1", "kicad-packages3d_6.0.10-1_all.deb",
        "e4ee3179c3935885a262e41543a675208ad5b3077d348728cac46f534d01109a",
    ): ((".wrl", "/copyright"), kicad),
    Package(
        "Debian", "sweethome3d-furniture", "1.8-1", "sweethome3d-furniture_1.8-1_all.deb",
        "3ccb90c63f9525e887a767b9cd5c8b6933b8b6b2973a615a5359ee68a2118668",
    ): ((".sh3f", "/copyright"), sweet_home),
    Package(
        "PyPI", "dm_control", "1.0.50", "dm_control-1.0.50-py3-none-any.whl",
        "5434e1e51ff69016867426da7df6064b18d140e4d0a628f879bbcf0e7d0a586d",
    ): ((".stl",), dog),
}


def download(package, folder):
    """The package's file in the folder: the one that is there, or else a new one."""
    path = folder / package.file
    if not path.exists():
        if package.registry == "Debian":
            command = ["apt-get", "download", f"{package.name}={package.version}"]
            hint = "`apt-get update` updates apt's lists; Debian 12 has this version"
        else:
            command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps",
                       "--only-binary", ":all:", "--dest", ".", f"{package.name}=={package.version}"]
            hint = "pip needs access to its index"
        try:
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
            why = done.stderr.strip().split("\n")[-1] if done.returncode else ""
        except OSError as error:
            why = str(error)
        if why or not path.exists():
            raise Problem(f"package {package} was not downloaded: {why or f'no file {package.file}'}\nhint: {hint}")
    with open(path, "rb") as file:
        found = hashlib.file_digest(file, "sha256").hexdigest()
    if found != package.sha256:
        raise Problem(f"package {package}: {path} has the SHA-256 {found} instead of {package.sha256}\n"
                      "hint: delete the file, so that it is downloaded again")
    return path


def unpack(package, path, endings, folder):
    """Writes the files of a package whose names end so."""
    try:
        if path.suffix == ".deb":
            with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", path], stdout=subprocess.PIPE) as process:
                with tarfile.open(fileobj=process.stdout, mode="r|") as archive:
                    for member in archive:
                        if member.isfile() and member.name.endswith(endings):
                            archive.extract(member, folder, filter="data")
            if process.returncode:
                raise OSError(f"dpkg-deb ended with status {process.returncode}")
        else:
            with zipfile.ZipFile(path) as archive:
                archive.extractall(folder, [name for name in archive.namelist() if name.endswith(endings)])
    except (OSError, tarfile.TarError, zipfile.BadZipFile) as error:
        raise Problem(f"package {package}: {path} was not unpacked: {error}") from None
