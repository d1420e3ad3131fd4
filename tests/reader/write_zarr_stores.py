#!/usr/bin/env python3
"""Writes stores of zarr-python into a folder, for zarr_test.cpp: write_zarr_stores.py FOLDER

Voxel (i, j, k) has the value (7 i + 5 j + 3 k) mod 100 in all types and codecs."""

import json
import pathlib
import sys

import numcodecs
import numpy
import zarr

folder = pathlib.Path(sys.argv[1])
random = numpy.random.default_rng(1)


def ramp(shape):
    k, j, i = numpy.meshgrid(*(numpy.arange(n) for n in shape), indexing="ij")
    return (7 * i + 5 * j + 3 * k) % 100


def image(name, levels, scales=None, translations=None, axes="zyx", unit="micrometer", attributes=None, **options):
    """A multiscale image of OME-Zarr 0.4, as ome-zarr-py writes it: transformations of scale alone, unless given."""
    group = zarr.open_group(str(folder / name), mode="w")
    datasets = []
    for n, level in enumerate(levels):
        options.setdefault("dimension_separator", "/")
        array = group.create_dataset(str(n), shape=level.shape, dtype=level.dtype, **options)
        array[...] = level
        transforms = [{"type": "scale", "scale": scales[n] if scales else [2.0**n if a in "zyx" else 1.0 for a in axes]}]
        if translations:
            transforms.append({"type": "translation", "translation": translations[n]})
        datasets.append({"path": str(n), "coordinateTransformations": transforms})
    kinds = {"t": "time", "c": "channel"}
    named = [{"name": a, "type": kinds.get(a, "space")} for a in axes]
    for axis in named:
        if unit and axis["type"] == "space":
            axis["unit"] = unit
        if axis["type"] == "time":
            axis["unit"] = "millisecond"
    group.attrs["multiscales"] = [{"version": "0.4", "axes": named, "datasets": datasets}]
    group.attrs.update(attributes or {})
    return group


def halved(level, rule):
    if rule == "every second":
        return level[::2, ::2, ::2]
    if rule == "the second of each pair":
        return level[1::2, 1::2, 1::2]
    if rule == "other":
        return random.integers(0, 200, [n // 2 for n in level.shape]).astype(level.dtype)
    k, j, i = (n // 2 for n in level.shape)
    means = level.astype(float).reshape(k, 2, j, 2, i, 2).mean(axis=(1, 3, 5))
    return (means if level.dtype.kind == "f" or rule == "means, cut" else numpy.floor(means + 0.5)).astype(level.dtype)


def pyramid(level, rule):
    levels = [level]
    for _ in range(2):
        levels.append(halved(levels[-1], rule))
    return levels


shape = (19, 37, 41)
for dtype in ("|b1", "|u1", "|i1", "<i2", ">i2", "<u2", ">u2", "<i4", ">i4", "<u4", "<f2", ">f2", "<f4", ">f4", "<f8", ">f8"):
    data = ramp(shape).astype(dtype)
    image("type " + dtype.replace("<", "l").replace(">", "b").replace("|", ""), [data], chunks=(8, 16, 16))
codecs = {"none": None, "zlib": numcodecs.Zlib(1), "gzip": numcodecs.GZip(1), "zstd": numcodecs.Zstd(1)}
for name in ("lz4", "lz4hc", "zstd", "zlib", "blosclz"):
    for shuffle in (0, 1, 2):
        codecs[f"blosc {name} {shuffle}"] = numcodecs.Blosc(name, 5, shuffle)
for name, codec in codecs.items():
    image("codec " + name, [ramp(shape).astype("<u2")], chunks=(16, 16, 16), compressor=codec)
for name, separator in (("dot", "."), ("slash", "/")):
    for order in "CF":
        image(f"layout {name} {order}", [ramp(shape).astype("<i2")], chunks=(7, 20, 13), dimension_separator=separator, order=order)
image("planes", [ramp(shape).astype("|u1")], chunks=(1, 37, 41))
image("one chunk", [ramp(shape).astype("|u1")], chunks=(64, 64, 64))

noise = (100 + 60 * numpy.sin(ramp((32, 48, 64)) / 9.0) + random.normal(0, 5, (32, 48, 64))).clip(0, 255)
for dtype in ("|u1", "<f4"):
    for rule in ("means", "means, cut", "every second", "the second of each pair", "other"):
        if dtype != "<f4" or rule != "means, cut":
            image(f"octaves {dtype[1:]} {rule}", pyramid(noise.astype(dtype), rule), chunks=(16, 16, 16))
halves = [[(2.0**n - 1) / 2] * 3 for n in range(3)]
image("octaves right means", pyramid(noise.astype("|u1"), "means"), translations=halves, chunks=(16, 16, 16))
image("octaves right every second", pyramid(noise.astype("|u1"), "every second"), translations=[[0.0] * 3] * 3, chunks=(16, 16, 16))
image("octaves wrong every second", pyramid(noise.astype("|u1"), "every second"), translations=halves, chunks=(16, 16, 16))
image("octaves constant", pyramid(numpy.full_like(noise, 7).astype("|u1"), "means"), chunks=(16, 16, 16))
flat = [noise.astype("|u1"), noise.astype("|u1")[:, ::2, ::2]]
image("octaves flat", flat, scales=[[1.0] * 3, [1.0, 2.0, 2.0]], chunks=(16, 16, 16))

five = numpy.zeros((3, 4, 6, 7, 8), "<i2")
five[...] = ramp((6, 7, 8)) + 100 * numpy.arange(4).reshape(1, 4, 1, 1, 1) + 1000 * numpy.arange(3).reshape(3, 1, 1, 1, 1)
labels = {"omero": {"channels": [{"label": name} for name in ("p", "vx", "vz", "vy")]}}
scales = [[20.0, 1.0, 2.0, 0.5, 0.25]]
image("five", [five], scales=scales, axes="tczyx", unit="nanometer", attributes=labels, chunks=(1, 1, 4, 4, 4))
image("five together", [five], scales=scales, axes="tczyx", unit="nanometer", attributes=labels, chunks=(2, 3, 4, 4, 4))
image("no unit", [ramp(shape).astype("|u1")], unit=None, chunks=(16, 16, 16))
plain = zarr.open_array(str(folder / "plain"), mode="w", shape=shape, chunks=(8, 16, 16), dtype="<u2")
plain[...] = ramp(shape)
sparse = zarr.open_array(str(folder / "sparse"), mode="w", shape=shape, chunks=(8, 16, 16), dtype="<f4", fill_value=float("nan"))
sparse[:8, :16, :16] = 5
for name, dtype in (("int64", "<i8"), ("complex64", "<c8")):
    image("refused " + name, [ramp(shape).astype(dtype)], chunks=(16, 16, 16))
image("refused filters", [ramp(shape).astype("<i4")], chunks=(16, 16, 16), filters=[numcodecs.Delta("<i4")])
image("refused lzma", [ramp(shape).astype("<i4")], chunks=(16, 16, 16), compressor=numcodecs.LZMA())
(folder / "done").write_text(json.dumps({"zarr": zarr.__version__}))
