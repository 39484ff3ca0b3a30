#!/usr/bin/env python3
"""Cohort's USDA reader against usd-core, in one run on the same files.

usage: bench_reader.py --bench BUILD/tests/bench/bench_reader_once --make make_big_usda.py
                       [--json] [--mb 100] [--prims 200000] [--references 10000] [--runs 5]
                       [--scaling 1,4,16,64]

The program bench_reader beside this calls it with both paths.

Both sides run in a process of their own, in turns; each figure is the median of the runs. The clock
stops after every array element has been summed, every composed prim visited and every transform
resolved. CPU seconds of one thread; peak memory is the largest resident size, mapped input included,
less what the process holds before it opens anything. Speed ratios are the reference's time over
Cohort's, memory ratios the reference's peak over Cohort's, the last ratio is Cohort's elapsed time on
the big mesh with one thread over that with two: more is better in each. --scaling reads meshes and
prims of so many MB by Cohort alone and prints MB per CPU second.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time


def memory(name):
    """Bytes of this process; not getrusage, which counts the process that started this one."""
    with open('/proc/self/status') as lines:
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(name))


def reference(path):
    import numpy
    from pxr import Usd, UsdGeom
    base = memory('VmRSS:')
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
    cpu, wall = time.process_time() - cpu, time.monotonic() - wall
    print(json.dumps({'cpu_seconds': cpu, 'wall_seconds': wall,
                      'peak_bytes': memory('VmHWM:') - base, 'prims': prims,
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


def run(command):
    env = dict(os.environ, PXR_WORK_THREAD_LIMIT='1', OMP_NUM_THREADS='1',
               TF_ENV_SETTING_ALERTS_ENABLED='0')
    out = subprocess.run(command, stdout=subprocess.PIPE, env=env, check=True).stdout
    return json.loads(out)


def middle(results, key):
    return statistics.median(result[key] for result in results)


def in_turns(args, first, second):
    pairs = [(run(first), run(second)) for _ in range(args.runs)]
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


def make(args, what, path, size):
    option = '--mb' if what == 'mesh' else '--count'
    subprocess.run([sys.executable, args.make, what, path, option, str(size)], check=True)
    return path


def compare(args, folder):
    """The six ratios, and for people the figures behind them."""
    mesh = make(args, 'mesh', os.path.join(folder, 'mesh.usda'), args.mb)
    files = {'mesh': mesh,
             'prims': make(args, 'prims', os.path.join(folder, 'prims.usda'), args.prims),
             'compose': write_references(folder, args.references)}
    ratios, figures = {}, {}
    for name, path in files.items():
        ours, theirs = in_turns(args, [args.bench, path, '1'],
                                [sys.executable, __file__, '--reference', path])
        for unit, key, scale in (('speed', 'cpu_seconds', 1), ('memory', 'peak_bytes', 1e-6)):
            ratios['%s_%s_ratio' % (name, unit)] = middle(theirs, key) / middle(ours, key)
            label = 'CPU seconds' if scale == 1 else 'peak MB'
            figures['%s %s, Cohort' % (name, label)] = middle(ours, key) * scale
            figures['%s %s, reference' % (name, label)] = middle(theirs, key) * scale
        figures[name + ' MB of text'] = os.path.getsize(path) * 1e-6
    one, two = in_turns(args, [args.bench, mesh, '1'], [args.bench, mesh, '2'])
    ratios['two_thread_speedup'] = middle(one, 'wall_seconds') / middle(two, 'wall_seconds')
    return ratios, figures


def scaling(args, folder):
    """MB per CPU second over sizes of text."""
    print('%8s %12s %12s' % ('MB', 'mesh MB/s', 'prims MB/s'))
    for mb in args.scaling.split(','):
        rates = []
        for what, size in (('mesh', float(mb)), ('prims', int(float(mb) * 3000))):
            path = make(args, what, os.path.join(folder, what + '.usda'), size)
            ours = [run([args.bench, path, '1']) for _ in range(args.runs)]
            rates.append(os.path.getsize(path) * 1e-6 / middle(ours, 'cpu_seconds'))
        print('%8s %12.0f %12.0f' % (mb, rates[0], rates[1]), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--reference', metavar='STAGE')
    parser.add_argument('--bench')
    parser.add_argument('--make')
    parser.add_argument('--json', action='store_true')
    parser.add_argument('--mb', type=float, default=100)
    parser.add_argument('--prims', type=int, default=200000)
    parser.add_argument('--references', type=int, default=10000)
    parser.add_argument('--runs', type=int, default=5)
    parser.add_argument('--scaling', metavar='SIZES')
    args = parser.parse_args()
    if args.reference:
        reference(args.reference)
        return 0
    if not args.bench or not args.make:
        parser.error('--bench and --make are needed')
    with tempfile.TemporaryDirectory() as folder:
        if args.scaling:
            scaling(args, folder)
            return 0
        ratios, figures = compare(args, folder)
    if args.json:
        print(json.dumps(ratios))
        return 0
    for name, value in list(figures.items()) + list(ratios.items()):
        print('%-36s %.3g' % (name, value))
    return 0


if __name__ == '__main__':
    sys.exit(main())
