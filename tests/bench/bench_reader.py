#!/usr/bin/env python3
"""Cohort's USDA reader against usd-core, in one run on the same files.

usage: bench_reader.py --bench BUILD/tests/bench/bench_reader --make make_big_usda.py
                       [--json] [--mb 100] [--prims 200000] [--references 10000] [--runs 5]

Both sides run in a process of their own, in turns; each figure is the median of the runs. The clock
stops after every array element has been summed, every composed prim visited and every transform
resolved. CPU seconds; peak memory is the resident size after that, less what the process needs
before it opens anything. Speed ratios are the reference's time over Cohort's, memory ratios the
reference's peak over Cohort's: more is better in each.
"""
import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time


def resident():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def reference(path):
    import numpy
    from pxr import Usd, UsdGeom
    base = resident()
    wall, cpu = time.monotonic(), time.process_time()
    stage = Usd.Stage.Open(path)
    total, prims, elements = 0.0, 0, 0
    at = Usd.TimeCode(0)
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        prims += 1
        xformable = UsdGeom.Xformable(prim)
        if xformable:
            total += xformable.GetLocalTransformation(at)[3][0]
        for attribute in prim.GetAuthoredAttributes():
            value = attribute.Get(at)
            if hasattr(value, '_isVtArray') or type(value).__module__ == 'pxr.Vt':
                array = numpy.asarray(value)
                if array.dtype.kind in 'iuf':
                    total += float(array.sum(dtype='float64'))
                elements += len(value)
    print(json.dumps({'cpu_seconds': time.process_time() - cpu,
                      'wall_seconds': time.monotonic() - wall,
                      'peak_bytes': resident() - base, 'prims': prims,
                      'elements': elements, 'sum': total}))


def write_references(folder, count):
    """A stage of `count` references to 50 assets of a few prims each."""
    for i in range(50):
        with open(os.path.join(folder, 'asset%02d.usda' % i), 'w') as out:
            out.write('#usda 1.0\n(\n    defaultPrim = "Asset"\n)\ndef Xform "Asset"\n{\n')
            for j in range(8):
                out.write('    def Mesh "part%d"\n    {\n' % j)
                out.write('        point3f[] points = [(0, 0, 0), (1, 0, 0), (%d, %d, 0)]\n' % (i, j))
                out.write('        int[] faceVertexCounts = [3]\n')
                out.write('        int[] faceVertexIndices = [0, 1, 2]\n')
                out.write('        double3 xformOp:translate = (%d, %d, 0)\n' % (i, j))
                out.write('        uniform token[] xformOpOrder = ["xformOp:translate"]\n    }\n')
            out.write('}\n')
    path = os.path.join(folder, 'references.usda')
    with open(path, 'w') as out:
        out.write('#usda 1.0\ndef Xform "World"\n{\n')
        for i in range(count):
            out.write('    def "r%d" (\n        references = @./asset%02d.usda@\n    )\n    {\n'
                      % (i, i % 50))
            out.write('        double3 xformOp:translate = (%d, 0, 0)\n' % i)
            out.write('        uniform token[] xformOpOrder = ["xformOp:translate"]\n    }\n')
        out.write('}\n')
    return path


def run(command, threads=1):
    env = dict(os.environ, PXR_WORK_THREAD_LIMIT=str(threads), OMP_NUM_THREADS=str(threads))
    out = subprocess.run(command, stdout=subprocess.PIPE, env=env, check=True).stdout
    return json.loads(out)


def middle(results, key):
    return statistics.median(result[key] for result in results)


def compare(path, args):
    ours, theirs = [], []
    for _ in range(args.runs):
        ours.append(run([args.bench, path]))
        theirs.append(run([sys.executable, __file__, '--reference', path]))
    return ours, theirs


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--reference', metavar='STAGE')
    parser.add_argument('--bench')
    parser.add_argument('--make')
    parser.add_argument('--json', action='store_true')
    parser.add_argument('--mb', type=int, default=100)
    parser.add_argument('--prims', type=int, default=200000)
    parser.add_argument('--references', type=int, default=10000)
    parser.add_argument('--runs', type=int, default=5)
    args = parser.parse_args()
    if args.reference:
        reference(args.reference)
        return 0
    if not args.bench or not args.make:
        parser.error('--bench and --make are needed')
    with tempfile.TemporaryDirectory() as folder:
        mesh, prims = os.path.join(folder, 'mesh.usda'), os.path.join(folder, 'prims.usda')
        subprocess.run([sys.executable, args.make, 'mesh', mesh, '--mb', str(args.mb)], check=True)
        subprocess.run([sys.executable, args.make, 'prims', prims, '--count', str(args.prims)],
                       check=True)
        files = {'mesh': mesh, 'prims': prims, 'compose': write_references(folder, args.references)}
        report = {}
        for name, path in files.items():
            ours, theirs = compare(path, args)
            report[name + '_speed_ratio'] = (middle(theirs, 'cpu_seconds') /
                                             middle(ours, 'cpu_seconds'))
            report[name + '_memory_ratio'] = (middle(theirs, 'peak_bytes') /
                                              middle(ours, 'peak_bytes'))
            report[name + '_cpu_seconds'] = middle(ours, 'cpu_seconds')
            report[name + '_mb'] = os.path.getsize(path) / 1e6
        one = [run([args.bench, mesh], 1) for _ in range(args.runs)]
        two = [run([args.bench, mesh], 2) for _ in range(args.runs)]
        report['two_thread_speedup'] = middle(one, 'wall_seconds') / middle(two, 'wall_seconds')
    print(json.dumps(report) if args.json else
          '\n'.join('%-24s %.3g' % item for item in report.items()))
    return 0


if __name__ == '__main__':
    sys.exit(main())
