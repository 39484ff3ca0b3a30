#!/usr/bin/env python3
"""Error against samples and CPU seconds, beside Mitsuba 3 (variant scalar_rgb, `pip install mitsuba`).

usage: bench_error.py COHORT STAGE REFERENCE.exr [--out DIR] [--spp N,N,...] [--mitsuba-spp N,N,...]

STAGE may hold Lambertian meshes (displayColor), rect lights and one camera: that is what the Mitsuba
scene is made from. REFERENCE is its converged image, linear R, G, B; its own error must be far below
what is measured. Both render paths of six segments with a box filter. Error is relMSE, the mean of
(I - R)^2 / (R^2 + 0.01) over pixels and channels, also without the worst 0.1% of pixels; time is user
CPU seconds of all threads, loading included for Cohort, not for Mitsuba. Writes error.json and, where
matplotlib is installed, error.png. Exits 1 when Cohort's slope over samples is flatter than -0.9 or it
needs more than twice Mitsuba's time to a relMSE of 1e-2. Needs numpy, OpenEXR, usd-core, mitsuba.
"""
import argparse
import json
import math
import os
import resource
import subprocess
import sys
import time

import numpy as np

SEGMENTS = 6
TARGET = 1e-2


def load_exr(path):
    import OpenEXR
    channels = OpenEXR.File(path, separate_channels=True).channels()
    return np.stack([np.asarray(channels[c].pixels, float) for c in 'RGB'], -1)


def errors(image, reference):
    terms = (image - reference) ** 2 / (reference ** 2 + 0.01)
    per_pixel = np.sort(terms.mean(-1).ravel())
    kept = per_pixel[:max(1, int(len(per_pixel) * 0.999))]
    return float(terms.mean()), float(kept.mean())


def run_cohort(args, spp):
    out = os.path.join(args.out, 'cohort_%d.exr' % spp)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([args.cohort, 'render', args.stage, '-o', out, '--spp', str(spp), '--max-depth',
                    str(SEGMENTS), '--filter', 'box', '--threads', '1', '--quiet'], check=True)
    return load_exr(out), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def mesh_dict(mi, prim, xform):
    from pxr import UsdGeom
    mesh = UsdGeom.Mesh(prim)
    points = np.array([xform.Transform(p) for p in map(tuple_to_vec, mesh.GetPointsAttr().Get())])
    counts, indices = mesh.GetFaceVertexCountsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    triangles, at = [], 0
    for n in counts:
        face = indices[at:at + n]
        triangles += [(face[0], face[k], face[k + 1]) for k in range(1, n - 1)]
        at += n
    colors = mesh.GetDisplayColorAttr().Get()
    albedo = [float(c) for c in colors[0]] if colors else [0.18] * 3
    props = mi.Properties()
    props['bsdf'] = mi.load_dict({'type': 'twosided', 'nested': {
        'type': 'diffuse', 'reflectance': {'type': 'rgb', 'value': albedo}}})
    props['face_normals'] = True
    out = mi.Mesh(prim.GetName(), len(points), len(triangles), has_vertex_normals=False,
                  has_vertex_texcoords=False, props=props)
    params = mi.traverse(out)
    floats, integers = type(params['vertex_positions']), type(params['faces'])
    params['vertex_positions'] = floats(points.astype(np.float32).ravel())
    params['faces'] = integers(np.array(triangles, np.uint32).ravel())
    params.update()
    return out


def tuple_to_vec(p):
    from pxr import Gf
    return Gf.Vec3d(*map(float, p))


def rect_dict(mi, prim, matrix):
    from pxr import UsdLux
    light = UsdLux.RectLight(prim)
    radiance = np.array(light.GetColorAttr().Get()) * light.GetIntensityAttr().Get()
    radiance = radiance * 2.0 ** light.GetExposureAttr().Get()
    # UsdLux shines along -Z, Mitsuba's rectangle along +Z.
    size = np.diag([light.GetWidthAttr().Get() / 2, light.GetHeightAttr().Get() / 2, -1, 1])
    return {'type': 'rectangle', 'to_world': mi.ScalarTransform4f((matrix @ size).tolist()),
            'bsdf': {'type': 'diffuse', 'reflectance': {'type': 'rgb', 'value': 0.0}},
            'emitter': {'type': 'area', 'radiance': {'type': 'rgb', 'value': radiance.tolist()}}}


def camera_dict(mi, prim, matrix, size):
    from pxr import UsdGeom
    camera = UsdGeom.Camera(prim).GetCamera(0).frustum.GetWindow()
    fov = 2 * math.degrees(math.atan(camera.GetMax()[0]))
    # Mitsuba looks along +Z with +X to the left.
    turn = np.diag([-1, 1, -1, 1])
    return {'type': 'perspective', 'fov': fov, 'fov_axis': 'x',
            'to_world': mi.ScalarTransform4f((matrix @ turn).tolist()),
            'film': {'type': 'hdrfilm', 'width': size[1], 'height': size[0],
                     'rfilter': {'type': 'box'}, 'pixel_format': 'rgb',
                     'component_format': 'float32'}, 'sampler': {'type': 'independent'}}


def mitsuba_scene(mi, path, size):
    from pxr import Usd, UsdGeom
    stage, scene = Usd.Stage.Open(path), {'type': 'scene'}
    scene['integrator'] = {'type': 'path', 'max_depth': SEGMENTS, 'rr_depth': 10000}
    for prim in stage.Traverse():
        xform = UsdGeom.XformCache().GetLocalToWorldTransform(prim)
        matrix = np.array(xform).T
        if prim.IsA(UsdGeom.Mesh):
            scene[prim.GetName()] = mesh_dict(mi, prim, xform)
        elif prim.GetTypeName() == 'RectLight':
            scene[prim.GetName()] = rect_dict(mi, prim, matrix)
        elif prim.IsA(UsdGeom.Camera):
            scene['sensor'] = camera_dict(mi, prim, matrix, size)
        elif 'Light' in prim.GetTypeName():
            raise SystemExit('%s: only rect lights are compared here' % prim.GetPath())
    return mi.load_dict(scene)


def run_mitsuba(mi, scene, spp):
    start = time.process_time()
    image = np.array(mi.render(scene, spp=spp, seed=spp))
    return image[..., :3].astype(float), time.process_time() - start


def slope(rows, x):
    points = np.log([[r[x], r['relmse']] for r in rows])
    return float(np.polyfit(points[:, 0], points[:, 1], 1)[0])


def seconds_to(rows, target):
    """Where the line through the two nearest measurements, in logarithms, reaches the target."""
    rows = sorted(rows, key=lambda r: abs(math.log(r['relmse'] / target)))[:2]
    (x0, y0), (x1, y1) = [(math.log(r['seconds']), math.log(r['relmse'])) for r in rows]
    return math.exp(x0 + (math.log(target) - y0) * (x1 - x0) / (y1 - y0))


def plot(report, path):
    try:
        import matplotlib
        matplotlib.use('Agg')
        from matplotlib import pyplot
    except ImportError:
        return
    figure, axes = pyplot.subplots(1, 2, figsize=(10, 4), sharey=True)
    for axis, x, label in zip(axes, ('spp', 'seconds'), ('samples per pixel', 'user CPU seconds')):
        for name in ('cohort', 'mitsuba'):
            rows = report[name]
            axis.loglog([r[x] for r in rows], [r['relmse'] for r in rows], 'o-', label=name)
        axis.set_xlabel(label)
        axis.grid(True, which='both', alpha=0.3)
    axes[0].set_ylabel('relMSE')
    axes[0].legend()
    figure.tight_layout()
    figure.savefig(path)


def measure(spps, render, reference):
    rows = []
    for spp in spps:
        image, seconds = render(spp)
        error, trimmed = errors(image, reference)
        rows.append({'spp': spp, 'seconds': seconds, 'relmse': error, 'relmse_trimmed': trimmed})
    return rows


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('cohort')
    parser.add_argument('stage')
    parser.add_argument('reference')
    parser.add_argument('--out', default='.')
    parser.add_argument('--spp', default='1,2,4,8,16,32,64,128')
    parser.add_argument('--mitsuba-spp', default='4,16,64,256')
    args = parser.parse_args()
    import mitsuba as mi
    mi.set_variant('scalar_rgb')
    os.makedirs(args.out, exist_ok=True)
    reference = load_exr(args.reference)
    scene = mitsuba_scene(mi, args.stage, reference.shape)
    numbers = lambda text: [int(n) for n in text.split(',')]
    report = {
        'stage': os.path.basename(args.stage),
        'cohort': measure(numbers(args.spp), lambda n: run_cohort(args, n), reference),
        'mitsuba': measure(numbers(args.mitsuba_spp), lambda n: run_mitsuba(mi, scene, n), reference),
    }
    for name in ('cohort', 'mitsuba'):
        report[name + '_slope'] = slope(report[name], 'spp')
        report[name + '_seconds_to_target'] = seconds_to(report[name], TARGET)
    report['time_ratio'] = (report['cohort_seconds_to_target'] /
                            report['mitsuba_seconds_to_target'])
    with open(os.path.join(args.out, 'error.json'), 'w') as f:
        json.dump(report, f, indent=1)
    plot(report, os.path.join(args.out, 'error.png'))
    print(json.dumps({k: v for k, v in report.items() if not isinstance(v, list)}))
    return 0 if report['cohort_slope'] <= -0.9 and report['time_ratio'] <= 2.0 else 1


if __name__ == '__main__':
    sys.exit(main())
