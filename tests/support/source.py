"""Exported source, compiled by cc and by node, as Python functions."""

import ctypes
import json
import shutil
import subprocess

import numpy as np

CC, NODE = shutil.which("cc"), shutil.which("node")
FLAGS = "-std=c99 -Wall -Wextra -Wno-unused-function -pedantic -Werror -O2 -ffp-contract=off"
CALLS = """
const answers = [];
for (const [name, t, y, p, n] of calls) {
  const out = new Array(n).fill(0);
  const raised = module[name](t, y, p, out);
  answers.push([Number(raised), out.map((x) => Object.is(x, -0) ? '-0' : String(x))]);
}
console.log(JSON.stringify(answers));
"""


class InC:
    """The functions of a `Code` in C."""

    def __init__(self, code, folder):
        texts = code.texts("c", "code")
        for end, text in texts.items():
            (folder / f"code{end}").write_text(text)
        library = folder / "code.so"
        given = [CC, *FLAGS.split(), "-shared", "-fPIC", "-o", library, folder / "code.c", "-lm"]
        done = subprocess.run(given, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        self.library, self.prefix = ctypes.CDLL(str(library)), code.name

    def __call__(self, calls):
        """[(whether the function raised, results)] of calls (name, t, y, p, n)."""
        found = []
        for name, t, y, p, n in calls:
            function = getattr(self.library, f"{self.prefix}_{name}")
            out, arrays = np.zeros(n), [np.array(y, float), np.array(p, float)]
            pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in (*arrays, out)]
            found.append((bool(function(ctypes.c_double(t), *pointers)), out))
        return found


class InJavaScript:
    """The functions of a `Code` in JavaScript."""

    def __init__(self, code, folder):
        self.file = folder / "code.mjs"
        self.file.write_text(code.texts("js", "code")[".js"])

    def __call__(self, calls):
        """As `InC`."""
        listed = [
            [name, float(t), np.asarray(y, float).tolist(), np.asarray(p, float).tolist(), n]
            for name, t, y, p, n in calls
        ]
        text = f"import * as module from {json.dumps(str(self.file))};\n"
        text += f"const calls = {json.dumps(listed)};\n{CALLS}"
        script = self.file.with_name("calls.mjs")
        script.write_text(text)
        done = subprocess.run([NODE, script], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        answers = json.loads(done.stdout)
        return [
            (bool(raised), np.array([float(x.replace("Infinity", "inf")) for x in out]))
            for raised, out in answers
        ]


COMPILED = {"c": (CC, InC), "js": (NODE, InJavaScript)}
