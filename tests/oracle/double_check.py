#!/usr/bin/env python3
"""Asks a double precision tracer who is right about the dark corner of renders/room.usda.

usage: double_check.py COHORT SHARED [--spp N] [--seeds N]

Renders the lower right 7 x 7 blocks of the image, where the nearest blob is, with Cohort, with
double_tracer.c as it stands, and with its rays started off the surfaces as Mitsuba 3 starts them;
prints the mean relative difference of the blocks for each pair, the reference included, with its
standard error. Takes about 20 CPU minutes. Needs cc, numpy, OpenEXR and pxr (usd-core).
"""
import argparse
import json
import os
import subprocess
import tempfile

import numpy as np
import OpenEXR
from pxr import Usd, UsdGeom, UsdLux

WIDTH, BLOCK, FIRST = 256, 16, 9  # blocks from FIRST on, in both directions
MITSUBA_OFFSET = 1500 * 2.0**-24  # its RayEpsilon, times 1 + the largest coordinate
COUNT = WIDTH // BLOCK - FIRST


def words(*values):
    return ' '.join('%.17g' % x for x in np.concatenate([np.ravel(v) for v in values]))


def scene_text(stage):
    """The stage as double_tracer.c reads it."""
    cache, triangles = UsdGeom.XformCache(), []
    for prim in stage.Traverse():
        m = np.array(cache.GetLocalToWorldTransform(prim)) if prim.IsA(UsdGeom.Xformable) else None
        if prim.IsA(UsdGeom.Camera):
            c = UsdGeom.Camera(prim)
            tangent = c.GetHorizontalApertureAttr().Get() / 2 / c.GetFocalLengthAttr().Get()
            camera = words(m[3, :3], m[0, :3], m[1, :3], m[2, :3], tangent)
        elif prim.IsA(UsdLux.RectLight):
            r = UsdLux.RectLight(prim)
            light = words(m[3, :3], m[0, :3] * r.GetWidthAttr().Get() / 2, m[1, :3] *
                          r.GetHeightAttr().Get() / 2, -m[2, :3], r.GetIntensityAttr().Get())
        elif prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            points = np.array(mesh.GetPointsAttr().Get(), float) @ m[:3, :3] + m[3, :3]
            color = mesh.GetDisplayColorAttr().Get()[0]
            for q in np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4):
                triangles += [words(points[q[[0, 1, 2]]], color), words(points[q[[0, 2, 3]]], color)]
    blocks = ['%d %d' % (x, y) for y in range(FIRST, FIRST + COUNT)
              for x in range(FIRST, FIRST + COUNT)]
    return '\n'.join([camera, light, str(len(triangles))] + triangles + blocks)


def crop(text):
    """The stage with a window on those blocks alone."""
    side, part = 20.955, COUNT / (WIDTH / BLOCK)
    shift = side * (1 - part) / 2
    for name, offset in (('horizontal', shift), ('vertical', -shift)):
        text = text.replace('float %sAperture = 20.955' % name,
                            'float %sAperture = %.9g\n        float %sApertureOffset = %.9g' %
                            (name, side * part, name, offset))
    return text.replace('(256, 256)', '(%d, %d)' % (COUNT * BLOCK, COUNT * BLOCK))


def cohort_blocks(cohort, stage, seed, spp, folder):
    image = os.path.join(folder, 'x.exr')
    subprocess.run([cohort, 'render', stage, '-o', image, '--spp', str(spp), '--max-depth', '6',
                    '--filter', 'box', '--seed', str(seed), '-q'], check=True)
    channels = OpenEXR.File(image, separate_channels=True).channels()
    rgb = np.stack([np.asarray(channels[c].pixels, float) for c in 'RGB'], -1)
    return rgb.reshape(COUNT, BLOCK, COUNT, BLOCK, 3).mean((1, 3))


def double_blocks(tracer, scene, seed, spp, offset):
    out = subprocess.run([tracer, str(WIDTH), str(spp), str(seed), str(offset)], input=scene,
                         capture_output=True, text=True, check=True).stdout
    return np.array([[float(x) for x in line.split()[2:]] for line in out.splitlines()]).reshape(
        COUNT, COUNT, 3)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('cohort')
    parser.add_argument('shared')
    parser.add_argument('--spp', type=int, default=256)
    parser.add_argument('--seeds', type=int, default=8)
    o = parser.parse_args()
    source = os.path.join(o.shared, 'renders', 'room.usda')
    with open(os.path.join(o.shared, 'renders', 'room_ref.json')) as f:
        ref = json.load(f)
    runs = {'cohort': [], 'double': [], 'double, offset': []}
    with tempfile.TemporaryDirectory() as folder:
        stage, tracer = os.path.join(folder, 'crop.usda'), os.path.join(folder, 'tracer')
        here = os.path.dirname(os.path.abspath(__file__))
        subprocess.run(['cc', '-O3', '-march=native', os.path.join(here, 'double_tracer.c'), '-o',
                        tracer, '-lm'], check=True)
        with open(source) as f, open(stage, 'w') as out:
            out.write(crop(f.read()))
        scene = scene_text(Usd.Stage.Open(source))
        for seed in range(1, o.seeds + 1):
            runs['cohort'].append(cohort_blocks(o.cohort, stage, seed, o.spp, folder))
            runs['double'].append(double_blocks(tracer, scene, seed, o.spp, 0))
            runs['double, offset'].append(
                double_blocks(tracer, scene, 1000 + seed, o.spp, MITSUBA_OFFSET))
    means = {k: np.mean(v, 0) for k, v in runs.items()}
    errors = {k: np.std(v, 0, ddof=1) / len(v)**0.5 for k, v in runs.items()}
    means['reference'] = np.array(ref['mean'])[FIRST:, FIRST:]
    errors['reference'] = np.array(ref['standard_error'])[FIRST:, FIRST:]
    for a, b in (('cohort', 'double'), ('reference', 'double'), ('reference', 'double, offset'),
                 ('cohort', 'reference')):
        difference = ((means[a] - means[b]) / means[b]).mean(-1)
        # The three channels of a block share their noise.
        error = (np.hypot(errors[a], errors[b]) / means[b]).mean(-1)
        print('%-10s - %-15s %+.3f%% +- %.3f%%' % (a, b, 100 * difference.mean(), 100 * np.sqrt(
            (error**2).sum()) / error.size))


main()
