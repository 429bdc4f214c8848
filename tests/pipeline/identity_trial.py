#!/usr/bin/env python3
"""identity_trial.py ANGIO FOLDER [UNTIL]: does anything of a patient come out?

Made-up names, numbers, dates and UIDs are planted in DICOM fields, private tags, file names, folders, and the
headers of NIfTI and NRRD. Every byte of every output (cases, logs, summaries; inside zlib, gzip and base64, too)
is then searched for them, as text, UTF-16, hexadecimal and base64. On the console a path may be named that was
typed; nothing else. Exit code 1 where something is found.
"""
import base64
import gzip
import pathlib
import re
import struct
import subprocess
import sys
import zlib

PROGRAM, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
UNTIL = sys.argv[3] if len(sys.argv) > 3 else "centerline"
# Only in fields, headers and contents; and only in names of files and folders.
FIELDS = ["Quastenflosser", "Brunhilde", "ZX47110815", "19450607", "Klinikum Entenhausen", "ACC998877",
          "1.2.826.0.1.3680043.9.424242", "0049303141592", "Hauptstrasse 17", "Privatvermerk"]
NAMES = ["Nachname_Vorname", "Geheimrat", "IM_Patientin"]


# ---- planting ----------------------------------------------------------------------------------

def elements(data, at):
    """Explicit little endian: (tag, bytes of the whole element)."""
    while at < len(data):
        group, number = struct.unpack_from("<HH", data, at)
        kind = data[at + 4:at + 6]
        if kind in (b"OB", b"OW", b"SQ", b"UN", b"UT", b"OF", b"OD", b"UC", b"UR"):
            size, head = struct.unpack_from("<I", data, at + 8)[0], 12
        else:
            size, head = struct.unpack_from("<H", data, at + 6)[0], 8
        if size == 0xFFFFFFFF:  # a sequence to its delimiter
            end = data.index(struct.pack("<HHI", 0xFFFE, 0xE0DD, 0), at) + 8
        else:
            end = at + head + size
        yield (group << 16) | number, data[at:end]
        at = end


def element(tag, kind, text):
    value = text.encode("latin-1")
    value += (b"\0" if kind == "UI" else b" ") * (len(value) % 2)
    head = struct.pack("<HH", tag >> 16, tag & 0xFFFF) + kind.encode()
    return head + (struct.pack("<HI", 0, len(value)) if kind == "UN" else struct.pack("<H", len(value))) + value


PLANTED = {
    0x00080020: ("DA", "19450607"), 0x00080050: ("SH", "ACC998877"), 0x00080080: ("LO", "Klinikum Entenhausen"),
    0x00081030: ("LO", "Brunhilde Befund"), 0x0008103E: ("LO", "Quastenflosser axial"),
    0x00100010: ("PN", "Quastenflosser^Brunhilde"), 0x00100020: ("LO", "ZX47110815"), 0x00100030: ("DA", "19450607"),
    0x00101040: ("LO", "Hauptstrasse 17"), 0x00102154: ("SH", "0049303141592"), 0x00104000: ("LT", "Quastenflosser"),
    0x00090010: ("LO", "Privatvermerk"), 0x00091001: ("UN", "Quastenflosser Brunhilde ZX47110815"),
    0x0020000D: ("UI", "1.2.826.0.1.3680043.9.424242.1"), 0x00204000: ("LT", "Brunhilde"),
    0x00400254: ("LO", "Quastenflosser"),
}


def plant_in_dicom(source, target):
    data = source.read_bytes()
    meta_size = struct.unpack_from("<I", data, 140)[0]
    start = 144 + meta_size
    found = dict(elements(data, start))
    for tag, (kind, text) in PLANTED.items():
        found[tag] = element(tag, kind, text)
    target.write_bytes(data[:start] + b"".join(found[tag] for tag in sorted(found)))


def make_inputs():
    made = FOLDER / "made"
    run("phantom", "unilateral", "-o", str(made / "dicom"), "--format", "dicom", "--length", "16", "--spacing", "0.5")
    run("phantom", "unilateral", "-o", str(made / "nrrd"), "--format", "nrrd", "--length", "16", "--spacing", "0.5")
    series = FOLDER / "Geheimrat" / "Nachname_Vorname"
    series.mkdir(parents=True)
    for number, file in enumerate(sorted((made / "dicom").rglob("*.dcm"))):
        plant_in_dicom(file, series / f"IM_Patientin{number}.dcm")
    nrrd = next((made / "nrrd").rglob("*.nrrd")).read_bytes()
    end = nrrd.index(b"\n\n")
    planted = nrrd[:end] + b"\n# Quastenflosser\nPatient:=Brunhilde ZX47110815\ncontent: Quastenflosser" + nrrd[end:]
    (series.parent / "Nachname_Vorname.nrrd").write_bytes(planted)
    (series.parent / "Nachname_Vorname.nii").write_bytes(nifti())
    damaged = series.parent / "IM_Patientin_damaged"
    damaged.mkdir()
    (damaged / "IM_Patientin.dcm").write_bytes(b"\0" * 128 + b"DICM" + b"\x10\x00\x10\x00PNQuastenflosser")
    (series.parent / "Nachname_Vorname_leer").mkdir()
    (series.parent / "Nachname_Vorname.stl").write_bytes(b"solid Quastenflosser\nfacet\n")
    return series


def nifti():
    size = 24
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, size, size, size, 1, 1, 1, 1)
    struct.pack_into("<hh", head, 70, 4, 16)
    struct.pack_into("<8f", head, 76, 1, 0.5, 0.5, 0.5, 1, 1, 1, 1)
    struct.pack_into("<ff", head, 108, 352, 1)
    head[148:148 + 34] = b"Quastenflosser Brunhilde 19450607 "
    head[228:228 + 16] = b"ZX47110815\0\0\0\0\0\0"
    struct.pack_into("<hh", head, 252, 0, 1)
    struct.pack_into("<12f", head, 280, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0)
    head[344:348] = b"n+1\0"
    voxels = [400 if (x - 12)**2 + (y - 12)**2 < 10 else 20 for _ in range(size) for y in range(size) for x in range(size)]
    return bytes(head) + struct.pack(f"<{len(voxels)}h", *voxels)


# ---- searching ---------------------------------------------------------------------------------

def spellings(word):
    """The bytes by which a word could stand in a file."""
    plain = word.encode()
    yield plain.lower()
    yield word.encode("utf-16-le").lower()
    yield word.encode("utf-16-be").lower()
    yield plain.hex().encode()
    for shift in range(3):  # base64 of a text that the word stands in
        encoded = base64.b64encode(b"\0" * shift + plain)
        yield encoded[(0, 2, 3)[shift]:len(encoded) - 4].lower()


def unpacked(data, depth=2):
    """The bytes themselves, and what zlib and gzip streams and base64 in them hold."""
    yield data
    if depth == 0:
        return
    for match in re.finditer(rb"\x78[\x01\x5e\x9c\xda]|\x1f\x8b\x08", data):
        stream = zlib.decompressobj(zlib.MAX_WBITS | 32)
        try:
            inner = stream.decompress(data[match.start():], 1 << 26)
        except zlib.error:
            continue
        if len(inner) > 16:
            yield from unpacked(inner, depth - 1)
    for match in re.finditer(rb"[A-Za-z0-9+/]{64,}={0,2}", data):
        text = match.group()
        yield from unpacked(base64.b64decode(text[:len(text) // 4 * 4]), depth - 1)


def search(data, words):
    found = set()
    for piece in unpacked(data):
        lower = piece.lower()
        found |= {word for word in words for spelling in spellings(word) if spelling in lower}
    return found


searched = {"files": 0, "bytes": 0}
leaks = []


def search_folder(folder):
    for file in sorted(folder.rglob("*")):
        leaks.extend((str(file.relative_to(FOLDER)) + " (its name)", word) for word in search(str(file.name).encode(), FIELDS + NAMES))
        if file.is_file():
            data = file.read_bytes()
            searched["files"] += 1
            searched["bytes"] += len(data)
            leaks.extend((str(file.relative_to(FOLDER)), word) for word in search(data, FIELDS + NAMES))


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, check=False)


def try_run(title, *arguments, words=FIELDS):
    """Runs the program and searches what it prints."""
    done = run(*arguments)
    leaks.extend((f"{title}: printed", word) for word in search(done.stdout + done.stderr, words))
    return done.returncode


def main():
    series = make_inputs()
    place = series.parent
    codes = {}
    outputs = FOLDER / "outputs"
    outputs.mkdir()
    options = ["--preset", "draft", "--until", UNTIL, "--backend", "cpu"]
    codes["inspect"] = try_run("inspect", "inspect", str(series))
    codes["inspect --json"] = try_run("inspect --json", "inspect", "--json", str(series))
    inputs = {"dicom": series, "nrrd": place / "Nachname_Vorname.nrrd", "nifti": place / "Nachname_Vorname.nii",
              "damaged": place / "IM_Patientin_damaged", "empty": place / "Nachname_Vorname_leer",
              "surface": place / "Nachname_Vorname.stl"}
    for name, path in inputs.items():
        codes[name] = try_run(name, "run", str(path), "-o", str(outputs / name), *options)
    codes["hidden"] = try_run("hidden", "run", str(inputs["damaged"]), "-o", str(outputs / "hidden"), "--hide-input",
                              *options, words=FIELDS + NAMES)
    # The manifest is the user's own; what the batch makes of it is searched.
    manifest = FOLDER / "cohort.csv"
    manifest.write_text("case,input\n" + "".join(f"{name},{path}\n" for name, path in inputs.items()), encoding="utf-8")
    codes["batch"] = try_run("batch", "batch", str(manifest), "-o", str(outputs / "batch"), "-j", "2", *options,
                             words=FIELDS + NAMES)
    search_folder(outputs)
    print("exit codes:", ", ".join(f"{name} {code}" for name, code in codes.items()))
    print(f"{searched['files']} files, {searched['bytes']} bytes searched for {len(FIELDS) + len(NAMES)} words")
    for place_found, word in leaks:
        print(f"LEAK {place_found}: {word}")
    wrong = [name for name in ("dicom", "nrrd", "inspect") if codes[name] != 0]
    if wrong:
        print("did not run:", ", ".join(wrong))
    return 1 if leaks or wrong else 0


# What is planted must be found, or nothing is shown.
for probe in ("Quastenflosser", "ZX47110815"):
    assert search(b"x" + probe.encode(), FIELDS) and search(probe.encode("utf-16-le"), FIELDS)
    assert search(b"ab" + gzip.compress(b"y" * 40 + probe.encode()), FIELDS)
    assert search(base64.b64encode(zlib.compress(b"z" * 99 + probe.encode() + bytes(range(99)))), FIELDS)
sys.exit(main())
