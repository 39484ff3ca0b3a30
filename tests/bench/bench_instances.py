#!/usr/bin/env python3
"""Renders 700 placements of a prototype of 16,000 small parts and reports time and peak memory.

usage: bench_instances.py COHORT [--parts N] [--placements N] [--own-points] [--instancer] [--keep DIR] [-- OPTIONS]

Each part is a mesh prim of twelve triangles with a transform of its own below one prototype prim. The
placements are instanceable references to it, or with --instancer the points of one PointInstancer. With
--own-points no two parts have the same points, so that nothing can be shared between them. OPTIONS go
to `cohort render`. Prints one line of JSON; exits 1 where the peak exceeds 1 GB.
"""
import argparse
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time

CUBE = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
FACES = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5]


def part(index, own_points):
    angle = index * 2.399963
    radius = math.sqrt(index + 0.5) * 0.05
    x, z = radius * math.cos(angle), radius * math.sin(angle)
    y = 0.5 * math.sin(radius)
    size = 0.02 * (1 + index * 1e-6 if own_points else 1)
    points = ', '.join('(%.8g, %.8g, %.8g)' % tuple(size * c for c in p) for p in CUBE)
    return '''    def Mesh "part_%d"
    {
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
        int[] faceVertexIndices = %s
        point3f[] points = [%s]
        uniform token subdivisionScheme = "none"
        double3 xformOp:translate = (%.6g, %.6g, %.6g)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
''' % (index, FACES, points, x, y, z)


def places(count):
    side = math.ceil(math.sqrt(count))
    return [((i % side - side / 2) * 14.0, 0.0, -(i // side) * 14.0) for i in range(count)]


def write_references(out, at):
    for i, p in enumerate(at):
        out.write('''def Xform "copy_%d" (
    instanceable = true
    references = </Prototype>
)
{
    double3 xformOp:translate = (%g, %g, %g)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
''' % (i, *p))


def write_instancer(out, at):
    out.write('''def PointInstancer "Copies"
{
    rel prototypes = </Prototype>
    int[] protoIndices = [%s]
    point3f[] positions = [%s]
}
''' % (', '.join(['0'] * len(at)), ', '.join('(%g, %g, %g)' % p for p in at)))


def write_stage(path, args):
    with open(path, 'w') as out:
        out.write('#usda 1.0\n(\n    upAxis = "Y"\n)\n')
        out.write('%s "Prototype"\n{\n' % ('def Xform' if args.instancer else 'class Xform'))
        if args.instancer:
            out.write('    token visibility = "inherited"\n')
        for i in range(args.parts):
            out.write(part(i, args.own_points))
        out.write('}\n')
        (write_instancer if args.instancer else write_references)(out, places(args.placements))
        out.write('''def Camera "Camera"
{
    float focalLength = 24
    float2 clippingRange = (0.1, 10000)
    double3 xformOp:translate = (0, 40, 60)
    float xformOp:rotateX = -25
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
}
def DomeLight "Sky"
{
    float inputs:intensity = 1
}
''')


def main():
    own = sys.argv[1:]
    options = []
    if '--' in own:
        options = own[own.index('--') + 1:]
        own = own[:own.index('--')]
    parser = argparse.ArgumentParser()
    parser.add_argument('cohort')
    parser.add_argument('--parts', type=int, default=16000)
    parser.add_argument('--placements', type=int, default=700)
    parser.add_argument('--own-points', action='store_true')
    parser.add_argument('--instancer', action='store_true')
    parser.add_argument('--keep')
    args = parser.parse_args(own)
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.keep or scratch
        stage, image = os.path.join(folder, 'instances.usda'), os.path.join(folder, 'instances.exr')
        stats_path = os.path.join(folder, 'instances.json')
        write_stage(stage, args)
        start = time.time()
        command = [args.cohort, 'render', stage, '-o', image, '--stats', stats_path]
        run = subprocess.run(command + (options or ['--spp', '4', '--max-depth', '4']))
        seconds = time.time() - start
        if run.returncode:
            return run.returncode
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        with open(stats_path) as f:
            stats = json.load(f)
    report = {'parts': args.parts, 'placements': args.placements, 'own_points': args.own_points,
              'instancer': args.instancer, 'peak_resident_mb': usage.ru_maxrss / 1024,
              'seconds': seconds, 'user_seconds': usage.ru_utime, 'rays': stats['rays']['traced'],
              'load_seconds': stats['seconds']['load'], 'scene': stats['scene'],
              'traversal': stats['traversal']}
    print(json.dumps(report))
    return 0 if report['peak_resident_mb'] < 1000 else 1


if __name__ == '__main__':
    sys.exit(main())
