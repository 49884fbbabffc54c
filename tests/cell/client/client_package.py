"""Installs the client library and the headers of device plug-ins, and builds their examples against them: with find_package, and
with pkg-config. `hecaton check` then loads the plug-in.

usage: client_package.py CMAKE BUILD EXAMPLES COMPILER"""
import os
import pathlib
import shutil
import subprocess
import sys

cmake, build, examples, compiler = sys.argv[1:]
folder = pathlib.Path(build).resolve() / "client_package"
shutil.rmtree(folder, ignore_errors=True)
prefix = folder / "prefix"
# Copies the sources, so that the build finds no other file of the tree.
project = folder / "project"
shutil.copytree(pathlib.Path(examples) / "client", project)


def run(*words, **options):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))} failed with {done.returncode}:\n{done.stdout}")
    return done.stdout


def expect_usage(program, **options):
    """Without arguments an example prints its usage: it was loaded with all its libraries."""
    done = subprocess.run([program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)
    if "usage:" not in done.stderr:
        sys.exit(f"{program} says: {done.stdout}{done.stderr}")


run(cmake, "--install", build, "--component", "client", "--prefix", prefix)
run(cmake, "-G", "Ninja", "-S", project, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={compiler}")
run(cmake, "--build", folder / "build")
for example in ("progress", "faults"):
    expect_usage(folder / "build" / example)

libdir = next(prefix.rglob("libhecaton-client.so")).parent
environment = dict(os.environ, PKG_CONFIG_PATH=str(libdir / "pkgconfig"))
flags = run("pkg-config", "--cflags", "--libs", "hecaton-client", env=environment).split()
program = folder / "progress_by_pkg_config"
run(compiler, project / "progress.cpp", *flags, "-o", program)
expect_usage(program, env=dict(os.environ, LD_LIBRARY_PATH=str(libdir)))

headers = sorted(path.name for path in (prefix / "include" / "hecaton").iterdir())
if headers != ["client.hpp", "enums.hpp", "types.hpp"]:
    sys.exit(f"installed headers: {headers}")
symbols = run("nm", "-D", "--defined-only", "-C", libdir / "libhecaton-client.so")
foreign = [line for line in symbols.splitlines() if "eprosima" in line or "hecaton::bus" in line or "hecaton::msg" in line]
if foreign:
    sys.exit("the shared library exports internal symbols:\n" + "\n".join(foreign[:10]))
plugin = folder / "plugin"
shutil.copytree(pathlib.Path(examples) / "device", plugin)
run(cmake, "-G", "Ninja", "-S", plugin, "-B", plugin / "build", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={compiler}")
run(cmake, "--build", plugin / "build")
cell = plugin / "cell.yaml"
cell.write_text("""name: plugin
arms:
  - name: left
    robot: ur5e
    device: {type: serial, plugin: build/libserial_arm.so, port: /dev/ttyUSB0}
""")
run(pathlib.Path(build) / "bin" / "hecaton", "check", cell)
print("the installed client library builds and loads, by find_package and by pkg-config; hecaton loads the device plug-in")
