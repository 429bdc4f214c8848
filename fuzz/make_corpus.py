#!/usr/bin/env python3
"""make_corpus.py FOLDER: the seeds of every fuzz target, made here: nothing in them is anybody's data."""
import base64
import gzip
import io
import json
import pathlib
import struct
import sys
import zipfile
import zlib

root = pathlib.Path(sys.argv[1])


def put(target, name, content):
    folder = root / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)


N = 6
VOXELS = struct.pack(f"<{N**3}h", *[(i * 37) % 400 for i in range(N**3)])


def tiff(compression):
    """Pages of N x N 16-bit pixels, a strip each."""
    content, strip = struct.pack("<2sHI", b"II", 42, 8), N * N * 2
    for page in range(N):
        data = len(content) + 2 + 9 * 12 + 4
        tags = {256: N, 257: N, 258: 16, 259: compression, 262: 1, 273: data, 277: 1, 278: N, 279: strip}
        content += struct.pack("<H", len(tags))
        content += b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items())
        content += struct.pack("<I", data + strip if page + 1 < N else 0)
        content += VOXELS[page * strip:(page + 1) * strip]
    return content


def volumes():
    head = (f"NRRD0005\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {N} {N} {N}\n"
            "space directions: (0.5,0,0) (0,0.5,0) (0,0,0.7)\nkinds: domain domain domain\nendian: little\n"
            "encoding: %s\nspace origin: (1,2,3)\n\n")
    put("nrrd", "raw.nrrd", (head % "raw").encode() + VOXELS)
    put("nrrd", "gzip.nrrd", (head % "gzip").encode() + gzip.compress(VOXELS, mtime=0))
    put("nrrd", "ras.nrrd", (head % "raw").replace("left-posterior", "right-anterior").encode() + VOXELS)
    mha = (f"ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
           f"CompressedData = %s\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\n"
           f"DimSize = {N} {N} {N}\nElementType = MET_SHORT\nElementDataFile = LOCAL\n")
    put("metaimage", "raw.mha", (mha % "False").encode() + VOXELS)
    packed = zlib.compress(VOXELS)
    put("metaimage", "zlib.mha",
        (mha % "True").replace("Offset", f"CompressedDataSize = {len(packed)}\nOffset").encode() + packed)
    put("tiff", "stack.tif", tiff(compression=1))
    put("tiff", "said_to_be_lzw.tif", tiff(compression=5))
    nii = bytearray(352)
    struct.pack_into("<i", nii, 0, 348)
    struct.pack_into("<8h", nii, 40, 3, N, N, N, 1, 1, 1, 1)
    struct.pack_into("<hh", nii, 70, 4, 16)
    struct.pack_into("<8f", nii, 76, 1, 0.5, 0.5, 0.7, 1, 1, 1, 1)
    struct.pack_into("<ff", nii, 108, 352, 1)
    nii[123] = 2
    struct.pack_into("<hh", nii, 252, 0, 1)
    struct.pack_into("<12f", nii, 280, -0.5, 0, 0, 0, 0, -0.5, 0, 0, 0, 0, 0.7, 0)
    nii[344:348] = b"n+1\0"
    put("nifti", "sform.nii", bytes(nii) + VOXELS)
    put("nifti_gz", "sform.nii.gz", gzip.compress(bytes(nii) + VOXELS, mtime=0))
    extent = f"0 {N-1} 0 {N-1} 0 {N-1}"
    vti = ('<?xml version="1.0"?>\n<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" '
           f'header_type="UInt32">\n<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="0.5 0.5 0.7">\n'
           f'<Piece Extent="{extent}">\n<PointData Scalars="v">\n<DataArray type="Int16" Name="v" format="%s">%s'
           "</DataArray>\n</PointData>\n</Piece>\n</ImageData>\n</VTKFile>\n")
    packed = base64.b64encode(struct.pack("<I", len(VOXELS)) + VOXELS).decode()
    put("vti", "base64.vti", vti % ("binary", packed))
    put("vti", "ascii.vti", vti % ("ascii", " ".join(map(str, struct.unpack(f"<{N**3}h", VOXELS)))))
    legacy = (f"# vtk DataFile Version 3.0\nt\n%s\nDATASET STRUCTURED_POINTS\nDIMENSIONS {N} {N} {N}\nORIGIN 0 0 0\n"
              f"SPACING 0.5 0.5 0.7\nPOINT_DATA {N**3}\nSCALARS v short 1\nLOOKUP_TABLE default\n")
    values = struct.unpack(f"<{N**3}h", VOXELS)
    put("vtk_image", "ascii.vtk", legacy % "ASCII" + " ".join(map(str, values)) + "\n")
    put("vtk_image", "binary.vtk", (legacy % "BINARY").encode() + struct.pack(f">{N**3}h", *values) + b"\n")


POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def gltf():
    """A tetrahedron as .gltf with its bytes in base64, and as .glb."""
    data = b"".join(struct.pack("<3f", *p) for p in POINTS) + b"".join(struct.pack("<3H", *f) for f in FACES)
    at = 12 * len(POINTS)
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
             "nodes": [{"mesh": 0, "translation": [1, 2, 3]}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 4}]}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(POINTS), "type": "VEC3"},
                           {"bufferView": 1, "componentType": 5123, "count": 3 * len(FACES), "type": "SCALAR"}],
             "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": at},
                             {"buffer": 0, "byteOffset": at, "byteLength": len(data) - at}],
             "buffers": [{"byteLength": len(data)}]}
    head = json.dumps(scene).encode()
    head += b" " * (-len(head) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = (struct.pack("<I4s", len(head), b"JSON") + head +
              struct.pack("<I4s", len(data), b"BIN\0") + data)
    put("gltf", "one.glb", struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    scene["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    put("gltf", "one.gltf", json.dumps(scene))


def surfaces():
    text = "solid t\n"
    binary = b"SPACE=LPS".ljust(80) + struct.pack("<I", 4)
    for face in FACES:
        corners = [POINTS[i] for i in face]
        text += "facet normal 0 0 0\n outer loop\n"
        text += "".join("  vertex %g %g %g\n" % p for p in corners) + " endloop\nendfacet\n"
        binary += struct.pack("<12fH", 0, 0, 0, *[c for p in corners for c in p], 0)
    put("stl", "ascii.stl", text + "endsolid t\n")
    put("stl", "binary.stl", binary)
    ply = ("ply\nformat %s 1.0\ncomment SPACE=LPS\nelement vertex 4\nproperty float x\nproperty float y\n"
           "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n")
    gltf()
    put("ply", "ascii.ply", ply % "ascii" + "".join("%g %g %g\n" % p for p in POINTS) +
        "".join("3 %d %d %d\n" % f for f in FACES))
    for order, name in (("<", "little"), (">", "big")):
        put("ply", name + ".ply", (ply % f"binary_{name}_endian").encode() +
            b"".join(struct.pack(order + "3f", *p) for p in POINTS) +
            b"".join(struct.pack(order + "B3i", 3, *f) for f in FACES))
    put("obj", "plain.obj", "# SPACE=LPS\n" + "".join("v %g %g %g\n" % p for p in POINTS) +
        "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in FACES))
    put("obj", "mixed.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvt 0 0\n"
        "f 1/1/1 2/1/1 3/1/1 4/1/1\nf -1//1 -2//1 -3//1\nusemtl x\ng y\n")
    legacy = "# vtk DataFile Version %s\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n%s\nPOLYGONS %s\n"
    text_points = " ".join("%g %g %g" % p for p in POINTS)
    put("vtk_polygons", "version_3.vtk", legacy % ("3.0", text_points, "4 16\n" + "".join("3 %d %d %d\n" % f for f in FACES)))
    put("vtk_polygons", "version_5.vtk", legacy % (
        "5.1", text_points, "5 12\nOFFSETS vtktypeint64\n0 3 6 9 12\nCONNECTIVITY vtktypeint64\n" +
        " ".join(str(i) for f in FACES for i in f)))
    xml = ('<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian">\n<PolyData>\n'
           '<Piece NumberOfPoints="4" NumberOfVerts="0" NumberOfLines="%d" NumberOfStrips="0" NumberOfPolys="%d">\n'
           '<PointData><DataArray type="Float64" Name="R" format="ascii">1 2 3 4</DataArray></PointData>\n'
           '<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">%s</DataArray></Points>\n'
           '<Lines><DataArray type="Int32" Name="connectivity" format="ascii">%s</DataArray>\n'
           '<DataArray type="Int32" Name="offsets" format="ascii">%s</DataArray></Lines>\n'
           '<Polys><DataArray type="Int32" Name="connectivity" format="ascii">%s</DataArray>\n'
           '<DataArray type="Int32" Name="offsets" format="ascii">%s</DataArray></Polys>\n'
           "</Piece></PolyData></VTKFile>\n")
    points = " ".join("%g %g %g" % p for p in POINTS)
    faces = " ".join(str(i) for f in FACES for i in f)
    put("vtp", "surface.vtp", xml % (0, 4, points, "", "", faces, "3 6 9 12"))
    put("vtp", "lines.vtp", xml % (2, 0, points, "0 1 2 1 3", "3 5", "", ""))
    grid = ('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">\n'
            '<UnstructuredGrid>\n<Piece NumberOfPoints="%d" NumberOfCells="1">\n'
            '<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">%s</DataArray></Points>\n'
            '<Cells><DataArray type="Int32" Name="connectivity" format="ascii">%s</DataArray>\n'
            '<DataArray type="Int32" Name="offsets" format="ascii">%d</DataArray>\n'
            '<DataArray type="UInt8" Name="types" format="ascii">%d</DataArray></Cells>\n'
            "</Piece></UnstructuredGrid></VTKFile>\n")
    put("vtu", "tet.vtu", grid % (4, points, "0 1 2 3", 4, 10))
    wedge = "0 0 0 1 0 0 0 1 0 0 0 1 1 0 1 0 1 1"
    put("vtu", "wedge.vtu", grid % (6, wedge, "0 1 2 3 4 5", 6, 13))


def element(group, number, kind, value):
    if isinstance(value, str):
        value = value.encode() + (b"\0" if kind == "UI" else b" ") * (len(value) % 2)
    long = kind in ("OB", "OW", "SQ", "UN")
    size = struct.pack("<HI", 0, len(value)) if long else struct.pack("<H", len(value))
    return struct.pack("<HH", group, number) + kind.encode() + size + value


def dicom(slice_number, syntax="1.2.840.10008.1.2.1", pixels=None):
    us = lambda v: struct.pack("<H", v)
    meta = (element(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.2") + element(2, 3, "UI", f"2.25.{slice_number + 1}") +
            element(2, 0x10, "UI", syntax))
    side = 8
    if pixels is None:
        pixels = element(0x7FE0, 0x10, "OW", struct.pack(f"<{side**2}H", *[(i * 13) % 900 for i in range(side**2)]))
    body = (element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2") + element(8, 0x18, "UI", f"2.25.{slice_number + 1}") +
            element(8, 0x60, "CS", "CT") + element(0x18, 0x50, "DS", "1") + element(0x20, 0xD, "UI", "2.25.77") +
            element(0x20, 0xE, "UI", "2.25.78") + element(0x20, 0x13, "IS", str(slice_number + 1)) +
            element(0x20, 0x32, "DS", f"0\\0\\{slice_number}") + element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") +
            element(0x28, 2, "US", us(1)) + element(0x28, 4, "CS", "MONOCHROME2") + element(0x28, 0x10, "US", us(side)) +
            element(0x28, 0x11, "US", us(side)) + element(0x28, 0x30, "DS", "0.5\\0.5") +
            element(0x28, 0x100, "US", us(16)) + element(0x28, 0x101, "US", us(12)) + element(0x28, 0x102, "US", us(11)) +
            element(0x28, 0x103, "US", us(0)) + element(0x28, 0x1052, "DS", "-1024") + element(0x28, 0x1053, "DS", "1") +
            pixels)
    return b"\0" * 128 + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + body


def archives():
    frame = b"".join(bytes([15]) + bytes(range(16)) for _ in range(4))
    rle = struct.pack("<16I", 2, 64, 64 + len(frame), *[0] * 13) + frame + frame
    item = lambda data: struct.pack("<HHI", 0xFFFE, 0xE000, len(data)) + data
    packed = (struct.pack("<HH", 0x7FE0, 0x10) + b"OB\0\0" + b"\xff" * 4 + item(b"") + item(rle) +
              struct.pack("<HHI", 0xFFFE, 0xE0DD, 0))
    for target in ("dicom_gate", "dicom_reader"):
        put(target, "plain.dcm", dicom(0))
        put(target, "rle.dcm", dicom(0, "1.2.840.10008.1.2.5", packed))
    for method, name in ((zipfile.ZIP_STORED, "stored.zip"), (zipfile.ZIP_DEFLATED, "deflated.zip")):
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", method) as archive:
            for number in range(3):
                archive.writestr(zipfile.ZipInfo(f"a/{number}.dcm"), dicom(number), method)
        put("zip", name, stream.getvalue())


def texts():
    put("csv", "profile.csv", "abscissa_mm,diameter_mm\n0,3.1\n0.5,\n1,2.9e0\n")
    put("csv", "quoted.csv", 'a;"b ""c""\nd";=1+1\r\n\r\n1;2;3\r\n')
    put("manifest", "cohort.csv", "case,input,preset,balloon,balloon.length_mm\nA,phantom:straight,draft,sc-3.0,20\n"
        "B,scan.nrrd,,,\n# a remark\n")
    put("manifest", "excel.csv", "\ufeffcase;input;inflation.peak_pressure_atm\r\nA;phantom:straight;7,5\r\n;;\r\n")
    matrix = "-10 0 0 50\n0 0 -10 40\n0 -0.001 0 1"
    put("geometry", "one.csv", ",".join(matrix.split()) + "\n" + ",".join(matrix.split()) + "\n")
    put("geometry", "rtk.xml", '<?xml version="1.0"?>\n<!DOCTYPE RTKGEOMETRY>\n<RTKThreeDCircularGeometry version="3">\n'
        "<SourceToIsocenterDistance>750</SourceToIsocenterDistance>\n"
        "<SourceToDetectorDistance>1200</SourceToDetectorDistance>\n<Projection>\n<GantryAngle>10</GantryAngle>\n"
        "<Matrix>\n-1200 0 0 0\n0 -1200 0 0\n0 0 1 -750\n</Matrix>\n</Projection>\n</RTKThreeDCircularGeometry>\n")
    put("toml", "options.toml", "[balloon]\nnominal_diameter_mm = 3.5\n[inflation]\npeak_pressure_atm = 8\n"
        "[segmentation]\nlabels = [1, 2]\n")
    put("toml", "nested.toml", "[a]\nb = [[[[[[[[1]]]]]]]]\nc = { d = { e = 1 } }\n")
    put("catalogue", "one.toml", '[[balloon]]\nname = "x-3.0"\nnominal_diameter_mm = 3.0\nlength_mm = 15\n'
        'material = "pa12"\nwall_um = 20\nnominal_atm = 8\nrated_burst_atm = 16\nchart = [[6, 2.9], [8, 3.0], [16, 3.2]]\n')
    record = {"program": "angio", "version": "0.1.0", "case": "a", "backend": "cpu", "device": "",
              "input": {"kind": "volume", "sha256": "00", "description": "CT"},
              "stages": {"segmentation": {"status": "done", "key": "1", "seconds": 1.0, "inputs": {},
                                          "outputs": {"run.json": "00"}, "warnings": ["w"]}}}
    put("case_folder", "one.txt", json.dumps(record, indent=2) + "\n%%\n[balloon]\nlength_mm = 20\n")
    put("case_folder", "odd.txt", json.dumps({"stages": {"simulation": {"status": "stale", "removed": [1]}}}))


volumes()
surfaces()
archives()
texts()
