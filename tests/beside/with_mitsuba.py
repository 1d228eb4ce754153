#!/usr/bin/env python3
"""Runs Mitsuba 3 beside iorect on the same scenes and says what each needs for equal error.

    pip install mitsuba numpy            (Mitsuba's fast variants need LLVM's library too, such as Debian's libllvm19)
    cargo build --release
    tests/beside/with_mitsuba.py                      all scenes
    tests/beside/with_mitsuba.py --quick              first figures in some minutes
    tests/beside/with_mitsuba.py s2 -o figures.json --variant "no splitting=--split off"

iorect is given closed objects; for Mitsuba every interface is cut apart and told its two IORs (cut.py), independently of iorect. Camera, light,
box filter and depth cap are the same. Mitsuba plays no Russian roulette unless asked to (--mitsuba-roulette); iorect always does, by a path's
throughput. Per scene:

1. Agreement. Two pictures by each program with seeds of their own are held against a reference that iorect rendered once (kept in --cache).
   Products of errors of *independent* pictures have no noise in their mean: of iorect's two pictures they estimate the reference's own
   error (its variance), of Mitsuba's two that and the squared bias between the programs. The difference is the bias; it should be zero within
   its standard error and below 1e-4, or one reference cannot serve both.
2. Time per sample without variance reduction: from the CPU time of whole processes at two sample counts, so that start-up cancels.
3. Time to equal error: whole processes, samples doubled until relMSE is below the target. relMSE is mean (x - r)²/(r² + 0.01), less the
   reference's own. The sample count that meets the target is interpolated on log-log; the time is start-up plus that count times the
   median time of a sample in runs of a quarter of it and more. CPU time is user and system time of the process (wait4), so it suffers little
   from what else runs; wall time does. Start-up is the same command for one sample of 16×16 pixels: for Mitsuba Python, imports, and
   loading kernels that an earlier run compiled (its cache is warm: each command runs once small before it counts; what a cold one costs is
   printed), for iorect loading, its tree and rectification. Both times, with and without start-up, are honest answers to different
   questions: the first is what a command costs, the second what a long render tends to.

All programs take turns for each point (A, B, A, B…), each run in a fresh process. Rows marked ~ never met the target and are extrapolated.
"""

import argparse
import glob
import hashlib
import json
import math
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.dont_write_bytecode = True
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent

SCENES = {
    "s1": ROOT / "tests/data/reference/s1.toml",
    "s2": ROOT / "tests/data/reference/s2.toml",
    "water": HERE / "water.toml",
}
# iorect's arguments: without any variance reduction (also what the reference is made with), and the curves.
IORECT_PLAIN = ["--sampler", "independent", "--splits", 0, "--adaptive", "off"]
IORECT_CURVES = {"iorect": [], "iorect uniform, unsplit": ["--splits", 0, "--adaptive", "off"]}
# Mitsuba's: sampler, and the segment from which Russian roulette ends paths.
NO_ROULETTE = 100_000
MITSUBA_PLAIN = ("independent", NO_ROULETTE)
MITSUBA_CURVES = {"mitsuba multijitter": ("multijitter", NO_ROULETTE), "mitsuba independent": ("independent", NO_ROULETTE)}
# What the others are compared with.
BASELINE = "mitsuba multijitter"

TARGET = 1e-3
BIAS_ALLOWED = 1e-4
BLOCK = 16


class Unusable(Exception):
    """Something is missing or does not work; the message says what to do."""


# Programs


class Iorect:
    def __init__(self, options, extra):
        self.options, self.extra = options, extra

    def command(self, scene, spp, seed, size, output):
        o = self.options
        return [o.iorect, "render", scene.path, "--spp", spp, "--seed", seed, "--size", f"{size}x{size}", "--max-depth", o.max_depth,
                "--threads", o.threads, "--mode", "rectified", "--json", "-o", output, *self.extra]


class Mitsuba:
    def __init__(self, options, sampler, rr_depth):
        self.options, self.sampler, self.rr_depth = options, sampler, rr_depth

    def command(self, scene, spp, seed, size, output):
        o = self.options
        return [sys.executable, HERE / "render.py", scene.cut, "--variant", o.mitsuba_variant, "--sampler", self.sampler, "--spp", spp,
                "--seed", seed, "--size", size, "--max-depth", o.max_depth, "--rr-depth", self.rr_depth, "--threads", o.threads,
                "-o", output]


class Run:
    """One fresh process: its CPU and wall time, the samples per pixel it really took, and its picture."""

    def __init__(self, program, scene, spp, seed, size, environment=None):
        with tempfile.TemporaryDirectory(prefix="beside-") as folder:
            output = Path(folder) / "picture.exr"
            command = [str(word) for word in program.command(scene, spp, seed, size, output)]
            with open(Path(folder) / "out", "w+") as out, open(Path(folder) / "errors", "w+") as errors:
                start = time.perf_counter()
                process = subprocess.Popen(command, stdout=out, stderr=errors, env={**os.environ, **(environment or {})})
                _, status, usage = os.wait4(process.pid, 0)
                self.wall = time.perf_counter() - start
                process.returncode = os.waitstatus_to_exitcode(status)
                out.seek(0)
                errors.seek(0)
                if process.returncode:
                    raise Unusable(f"exit code {process.returncode} of: {' '.join(command)}\n{errors.read().strip()}")
                self.spp = json.load(out)["spp"]
            self.cpu = usage.ru_utime + usage.ru_stime
            self.picture = read_exr(output)


class Scene:
    def __init__(self, name, path, cut_folder):
        self.name, self.path, self.cut = name, path, cut_folder


def read_exr(path):
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.array(bitmap, dtype=np.float64)


# Error


def cross_error(a, b, reference):
    """(a - r)(b - r)/(r² + 0.01) in each pixel; the mean of a = b is relMSE. Independent a and b leave bias² and the reference's variance."""
    return ((a - reference) * (b - reference) / (reference**2 + 0.01)).mean(2)


def mean_and_error(values):
    """Mean of an image, and its standard error from the spread of 32×32 tiles (too large where tiles differ for real)."""
    tiles = [part.mean() for row in np.array_split(values, 32) for part in np.array_split(row, 32, axis=1)]
    return float(values.mean()), statistics.stdev(tiles) / math.sqrt(len(tiles))


def blocks(picture):
    height, width = (length // BLOCK * BLOCK for length in picture.shape[:2])
    return picture[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean((1, 3))


def agreement(scene, reference, options):
    """The bias between the programs and the variance of the reference, without the noise of the pictures."""
    pairs = {}
    for name, program in (("iorect", Iorect(options, IORECT_PLAIN)), ("mitsuba", Mitsuba(options, *MITSUBA_PLAIN))):
        say(f"{scene.name}: agreement, {name}")
        pairs[name] = [Run(program, scene, options.check_spp, 7001 + i, options.size).picture for i in range(2)]
    own = cross_error(*pairs["iorect"], reference)
    other = cross_error(*pairs["mitsuba"], reference)
    bias, bias_error = mean_and_error(other - own)
    variance, variance_error = mean_and_error(own)
    in_blocks = {
        name: float(cross_error(*[blocks(sum(pair) / 2)] * 2, blocks(reference)).mean()) for name, pair in pairs.items()
    }
    return {
        "spp": options.check_spp,
        "bias": bias,
        "bias_standard_error": bias_error,
        "reference_variance": max(variance, 0.0),
        "reference_variance_standard_error": variance_error,
        "relmse_of_block_means": in_blocks,
        "mean": {"reference": float(reference.mean()), **{name: float((sum(pair) / 2).mean()) for name, pair in pairs.items()}},
        "agrees": abs(bias) < BIAS_ALLOWED,
    }


def reference_of(scene, options):
    given = options.references.get(scene.name)
    if given:
        picture = read_exr(given)
        if picture.shape[:2] != (options.size, options.size):
            raise Unusable(f"{given}: is {picture.shape[1]}x{picture.shape[0]}, not {options.size}x{options.size}")
        return picture
    # What the picture depends on; a newer binary should agree, and the check above says so if it does not.
    key = f"{scene.cut.name} {options.size} {options.max_depth} {options.reference_spp}"
    kept = options.cache / f"{scene.name}-reference-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npy"
    if kept.exists():
        return np.load(kept)
    say(f"{scene.name}: reference, {options.reference_spp} samples a pixel, once")
    picture = Run(Iorect(options, IORECT_PLAIN), scene, options.reference_spp, 1001, options.size).picture
    np.save(kept, picture.astype(np.float32))
    return picture


# Time


def start_up(programs, scene, options):
    """CPU and wall time of one sample of 16×16 pixels; for Mitsuba also with an empty kernel cache."""
    times = {name: [] for name in programs}
    for turn in range(options.repeats + 1):
        for name, program in programs.items():
            run = Run(program, scene, 1, turn, 16)
            if turn:
                times[name].append(run)
    result = {
        name: {"cpu": statistics.median(r.cpu for r in runs), "wall": statistics.median(r.wall for r in runs)}
        for name, runs in times.items()
    }
    with tempfile.TemporaryDirectory(prefix="beside-") as home:
        run = Run(programs[BASELINE], scene, 1, 0, 16, {"HOME": home})
    result[BASELINE]["cold_cpu"], result[BASELINE]["cold_wall"] = run.cpu, run.wall
    return result


def per_sample(scene, options):
    """CPU and wall time of one sample without variance reduction, as medians over turns."""
    programs = {"mitsuba": Mitsuba(options, *MITSUBA_PLAIN), "iorect": Iorect(options, IORECT_PLAIN)}
    few, many = options.per_sample_spp
    slopes = {name: {"cpu": [], "wall": []} for name in programs}
    for program in programs.values():
        for spp in (few, many):
            Run(program, scene, spp, 0, 16)
    for turn in range(options.repeats):
        for name, program in programs.items():
            say(f"{scene.name}: time per sample, turn {turn + 1}, {name}")
            small, large = (Run(program, scene, spp, 100 + turn, options.size) for spp in (few, many))
            samples = (large.spp - small.spp) * options.size**2
            for clock, seconds in slopes[name].items():
                seconds.append((getattr(large, clock) - getattr(small, clock)) / samples)
    result = {
        name: {f"{clock}_ns": 1e9 * statistics.median(seconds) for clock, seconds in clocks.items()} for name, clocks in slopes.items()
    }
    result["ratio_cpu"] = statistics.median(i / m for i, m in zip(slopes["iorect"]["cpu"], slopes["mitsuba"]["cpu"]))
    return result


def curves(programs, scene, reference, variance, options):
    """Points (spp, relMSE, CPU time, wall time) of every program until it meets the target."""
    points = {name: [] for name in programs}
    biases = {}
    spp = options.first_spp
    while spp <= options.most_spp:
        runs = {name: [] for name in programs if not met(points[name], options)}
        if not runs:
            break
        for name in runs:
            Run(programs[name], scene, spp, 0, 16)
        for seed in range(options.seeds):
            for name in runs:
                say(f"{scene.name}: {spp} samples a pixel, seed {seed + 1}, {name}")
                runs[name].append(Run(programs[name], scene, spp, seed + 1, options.size))
        for name, of_seeds in runs.items():
            errors = [float(cross_error(r.picture, r.picture, reference).mean()) - variance for r in of_seeds]
            points[name].append({
                "spp": of_seeds[0].spp,
                "relmse": statistics.fmean(errors),
                "cpu": [r.cpu for r in of_seeds],
                "wall": [r.wall for r in of_seeds],
            })
            if len(of_seeds) > 1:
                product, error = mean_and_error(cross_error(of_seeds[0].picture, of_seeds[1].picture, reference))
                biases[name] = {"bias": product - variance, "standard_error": error, "spp": of_seeds[0].spp}
        spp *= 2
    return points, biases


def met(points, options):
    return bool(points) and points[-1]["relmse"] < options.target


def at_target(points, start, options):
    """Samples per pixel and times at which the target is met; `None` if the points do not tell."""
    spp, error = ([point[key] for point in points] for key in ("spp", "relmse"))
    if error[0] < options.target:
        needed = spp[0]
    elif len(points) == 1 or error[-1] <= 0 or error[-1] >= error[-2]:
        return None
    else:
        slope = math.log(error[-1] / error[-2]) / math.log(spp[-1] / spp[-2])
        needed = spp[-2] * math.exp(math.log(options.target / error[-2]) / slope)
    result = {"spp": needed, "extrapolated": not met(points, options)}
    # What else runs now and then costs single runs half their speed: the median over runs of like length withstands that.
    alike = [point for point in points if point["spp"] >= needed / 4] or points[-1:]
    for clock in ("cpu", "wall"):
        rate = statistics.median((seconds - start[clock]) / point["spp"] for point in alike for seconds in point[clock])
        result[f"{clock}_without_start_up"] = needed * rate
        result[clock] = start[clock] + needed * rate
    return result


# Report


def say(message):
    if sys.stderr.isatty():
        sys.stderr.write(f"\r\033[K{message} ")
        sys.stderr.flush()


def report(name, result, options):
    say("")
    check, sample = result["agreement"], result["per_sample"]
    bias = f"{check['bias']:+.1e} ± {check['bias_standard_error']:.0e}"
    lines = [
        f"== {name}: {options.size}×{options.size}, at most {options.max_depth} segments, {options.threads} threads",
        "",
        f"  agreement    bias {bias} relMSE{'' if check['agrees'] else ': TOO LARGE, the figures below are not comparable'}; of {BLOCK}×{BLOCK}"
        f" block means " + ", ".join(f"{who} {value:.1e}" for who, value in check["relmse_of_block_means"].items()),
        "               mean " + ", ".join(f"{who} {value:.6f}" for who, value in check["mean"].items())
        + f"; the reference's own relMSE {check['reference_variance']:.2e} ± {check['reference_variance_standard_error']:.0e} is taken off below",
        f"  per sample   without variance reduction: mitsuba {sample['mitsuba']['cpu_ns']:.0f} ns, iorect {sample['iorect']['cpu_ns']:.0f} ns of CPU"
        f" time, ratio {sample['ratio_cpu']:.2f}; wall {sample['mitsuba']['wall_ns']:.0f} and {sample['iorect']['wall_ns']:.0f} ns",
        "  start-up     " + ", ".join(f"{who} {times['cpu']:.2f} s" for who, times in result["start_up"].items())
        + f" of CPU time; {BASELINE} with nothing compiled yet {result['start_up'][BASELINE]['cold_cpu']:.2f} s",
        "",
        f"  {'':24}{'spp':>6}{'relMSE':>11}{'CPU s':>9}{'wall s':>9}",
    ]
    for who, points in result["curves"].items():
        for i, point in enumerate(points):
            cpu, wall = (statistics.median(point[clock]) for clock in ("cpu", "wall"))
            lines.append(f"  {who if i == 0 else '':24}{point['spp']:>6}{point['relmse']:>11.3e}{cpu:>9.2f}{wall:>9.2f}")
    for who, bias in result["biases"].items():
        lines.append(f"  {who + ', bias':24}{bias['spp']:>6}{bias['bias']:>+11.1e} ± {bias['standard_error']:.0e}")
    lines += [
        "",
        f"  to relMSE {options.target:g}",
        f"  {'':24}{'spp':>7}{'CPU s':>9}{'ratio':>8}{'less start-up':>15}{'ratio':>8}{'wall s':>9}",
    ]
    base = result["to_target"].get(BASELINE)
    for who, cost in result["to_target"].items():
        if cost is None:
            lines.append(f"  {who:24}{'not met':>7}")
            continue
        ratios = {key: f"{cost[key] / base[key]:.2f}" if base else "" for key in ("cpu", "cpu_without_start_up")}
        mark = "~" if cost["extrapolated"] else " "
        lines.append(f"  {who:23}{mark}{cost['spp']:>7.1f}{cost['cpu']:>9.2f}{ratios['cpu']:>8}{cost['cpu_without_start_up']:>15.2f}"
                     f"{ratios['cpu_without_start_up']:>8}{cost['wall']:>9.2f}")
    print("\n".join(lines) + "\n", flush=True)


# Set-up


def find_llvm():
    """Tells Dr.Jit where LLVM's library is; without it Mitsuba has no fast variant on a CPU."""
    if os.environ.get("DRJIT_LIBLLVM_PATH"):
        return
    found = []
    for pattern in ("/usr/lib/*/libLLVM*.so*", "/usr/lib/llvm*/lib*/libLLVM*.so*", "/usr/lib64/libLLVM*.so*", "/usr/lib/libLLVM*.so*",
                    "/opt/homebrew/opt/llvm*/lib/libLLVM*.dylib", "/usr/local/opt/llvm*/lib/libLLVM*.dylib"):
        for path in glob.glob(pattern):
            version = re.search(r"(\d+)", Path(path).resolve().name.removeprefix("libLLVM"))
            found.append((int(version[1]) if version else 0, path))
    if not found:
        raise Unusable("LLVM's library is missing: install it (Debian: apt install libllvm19; macOS: brew install llvm) or set"
                       " DRJIT_LIBLLVM_PATH to it")
    os.environ["DRJIT_LIBLLVM_PATH"] = max(found)[1]


def import_what_is_needed():
    global mi, np
    if sys.version_info < (3, 11):
        raise Unusable("Python 3.11 or newer is needed")
    try:
        import mitsuba as mi
        import numpy as np
    except ImportError as error:
        raise Unusable(f"{error}: install it with `pip install mitsuba numpy`") from error
    mi.set_variant("scalar_rgb")


def parse():
    description, _, rest = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(description=description, epilog=rest, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(SCENES)}, or scene files (default: all of the former)")
    add("--quick", action="store_true", help="fewer repetitions and a coarser reference")
    add("--iorect", default=ROOT / "target/release/iorect", type=Path, help="its binary (default: target/release/iorect)")
    add("--variant", action="append", default=[], metavar="NAME=ARGUMENTS", help="one more curve of iorect, with these arguments")
    add("--mitsuba-roulette", action="store_true", help="one more curve of Mitsuba, with roulette from segment 5, its default")
    add("--mitsuba-variant", default="llvm_ad_rgb", help="(default: %(default)s)")
    add("--size", type=int, default=512, help="pixels on a side (default: %(default)s)")
    add("--max-depth", type=int, default=32, help="most segments of a path (default: %(default)s)")
    add("--threads", type=int, default=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        help="of both programs (default: %(default)s, all)")
    add("--target", type=float, default=TARGET, help="relMSE to be met (default: %(default)s)")
    add("--first-spp", type=int, help="where the curves begin (default: 1, quick 8)")
    add("--most-spp", type=int, default=256, help="where they end if the target is not met (default: %(default)s)")
    add("--seeds", type=int, help="pictures for each point (default: 2, quick 1)")
    add("--repeats", type=int, help="turns of the other timings (default: 5, quick 2)")
    add("--check-spp", type=int, help="samples of each picture of the agreement (default: 64, quick 32)")
    add("--per-sample-spp", type=int, nargs=2, metavar=("FEW", "MANY"), help="(default: 4 36, quick 4 16)")
    add("--reference-spp", type=int, help="samples of references that are made here (default: 1024, quick 256)")
    add("--reference", action="append", default=[], metavar="SCENE=FILE.exr", help="use this picture as the reference of a scene")
    add("--cache", type=Path, default=Path(tempfile.gettempdir()) / "iorect-beside", help="for scenes cut apart and references (default: %(default)s)")
    add("-o", "--output", type=Path, metavar="FILE.json", help="all figures as JSON")
    options = parser.parse_args()
    full_and_quick = {"first_spp": (1, 8), "seeds": (2, 1), "repeats": (5, 2), "check_spp": (64, 32), "per_sample_spp": ([4, 36], [4, 16]),
                      "reference_spp": (1024, 256)}
    for name, values in full_and_quick.items():
        if getattr(options, name) is None:
            setattr(options, name, values[options.quick])
    if options.size < 64:
        parser.error("--size: smaller pictures than 64 say nothing about error")
    options.references = {}
    for words in options.reference:
        name, is_pair, path = words.partition("=")
        if not is_pair or not Path(path).is_file():
            parser.error(f"--reference {words}: must be SCENE=FILE, and the file must be there")
        options.references[name] = path
    options.curves = {name: Iorect(options, extra) for name, extra in IORECT_CURVES.items()}
    for words in options.variant:
        name, is_pair, extra = words.partition("=")
        if not is_pair:
            parser.error(f"--variant {words}: must be NAME=ARGUMENTS")
        options.curves[f"iorect {name}"] = Iorect(options, extra.split())
    mitsuba = dict(MITSUBA_CURVES)
    if options.mitsuba_roulette:
        mitsuba["mitsuba mj., roulette"] = ("multijitter", 5)
    options.curves = {name: Mitsuba(options, *setting) for name, setting in mitsuba.items()} | options.curves
    options.paths = {}
    for scene in options.scenes or SCENES:
        path = SCENES.get(scene, Path(scene))
        if not path.is_file():
            parser.error(f"{scene}: neither a file nor one of {', '.join(SCENES)}")
        options.paths[scene if scene in SCENES else path.stem] = path.resolve()
    return options


def machine():
    model = platform.processor()
    if Path("/proc/cpuinfo").exists():
        names = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
        model = names[0] if names else model
    return {"processor": model, "cores": os.cpu_count(), "system": platform.platform(), "load_average": os.getloadavg()}


def main():
    options = parse()
    import_what_is_needed()
    find_llvm()
    # Needs numpy, whose absence should be said in plain words.
    import cut

    options.iorect = options.iorect.resolve()
    if not os.access(options.iorect, os.X_OK):
        raise Unusable(f"{options.iorect}: no such program; `cargo build --release` makes it, --iorect names another")
    options.cache.mkdir(parents=True, exist_ok=True)
    version = subprocess.run([options.iorect, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    result = {"machine": machine(), "iorect": version, "mitsuba": mi.__version__, "mitsuba_variant": options.mitsuba_variant,
              "size": options.size, "max_depth": options.max_depth, "threads": options.threads, "target": options.target, "scenes": {}}
    print(f"{version} beside Mitsuba {mi.__version__} ({options.mitsuba_variant}), {result['machine']['processor']}, load"
          f" {result['machine']['load_average'][0]:.1f}\n", flush=True)
    for name, path in options.paths.items():
        try:
            scene = Scene(name, path, cut.cut(path, options.cache))
        except (cut.SceneError, OSError) as error:
            raise Unusable(error) from error
        found = {"start_up": start_up(options.curves, scene, options)}
        reference = reference_of(scene, options)
        found["agreement"] = agreement(scene, reference, options)
        found["per_sample"] = per_sample(scene, options)
        found["curves"], found["biases"] = curves(
            options.curves, scene, reference, found["agreement"]["reference_variance"], options)
        found["to_target"] = {who: at_target(points, found["start_up"][who], options) for who, points in found["curves"].items()}
        result["scenes"][name] = found
        report(name, found, options)
        if options.output:
            options.output.write_text(json.dumps(result, indent=2) + "\n")
    return 0 if all(found["agreement"]["agrees"] for found in result["scenes"].values()) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Unusable as error:
        sys.exit(f"with_mitsuba.py: {error}")
    except KeyboardInterrupt:
        sys.exit(130)
