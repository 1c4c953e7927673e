// Solves a system as fastdyn does: loops over steps, dense output, events, phases.
//
// A function of a system is f(t, y, p, out); it returns true where the Python function raises.
// The methods are written from fastdyn's tables, see `methods.py`.
const RUNNING = 0, RAISED = "raised", TOO_SMALL = "too small", NOT_FINITE = "not finite";
const UNSOLVED = "unsolved", TOO_LONG = "too long";
const SENTENCES = {
  [RAISED]: "The equations are not defined there.",
  [TOO_SMALL]: "Required step size is less than spacing between numbers.",
  [NOT_FINITE]: "The state is not finite any more.",
  [UNSOLVED]: "The iteration of the implicit step does not converge: take a smaller step.",
  [TOO_LONG]: "The run was ended after its largest number of steps.",
};
const SAFETY = 0.9, MIN_FACTOR = 0.2, MAX_FACTOR = 10, LANDED = 1e-6;
const TOLERANCE = 4 * Number.EPSILON;
const PARTS = 8; // of a step, between which events are sought, as in kernels/output/arguments.py

// The distance from a time, not negative, to the next larger number.
const bytes = new DataView(new ArrayBuffer(8));
function spacing(t) {
  bytes.setFloat64(0, t);
  const low = bytes.getUint32(4);
  bytes.setUint32(4, low + 1);
  if (low === 4294967295) bytes.setUint32(0, bytes.getUint32(0) + 1);
  return bytes.getFloat64(0) - t;
}

function zeros(n) { return new Float64Array(n); }
function rows(count, n) { return Array.from({ length: count }, () => zeros(n)); }

function scaledRms(values, y, rtol, atol) {
  let total = 0;
  for (let i = 0; i < y.length; i++) {
    const x = values[i] / (atol + Math.abs(y[i]) * rtol);
    total += x * x;
  }
  return Math.sqrt(total / y.length);
}

// The first step of Hairer, Norsett and Wanner, section II.4.
function firstStep(run, k) {
  const { f, p, t, y, rtol, atol, method, tf } = run, n = y.length, span = tf - t;
  const size = scaledRms(y, y, rtol, atol), slope = scaledRms(k, y, rtol, atol);
  const h = Math.min(size < 1e-5 || slope < 1e-5 ? 1e-6 : 0.01 * size / slope, span);
  const u = zeros(n), probe = zeros(n);
  for (let i = 0; i < n; i++) u[i] = y[i] + h * k[i];
  run.nfev++;
  if (f(t + h, u, p, probe)) return NaN;
  for (let i = 0; i < n; i++) probe[i] -= k[i];
  const curvature = scaledRms(probe, y, rtol, atol) / h;
  const longer = slope <= 1e-15 && curvature <= 1e-15 ? Math.max(1e-6, h * 1e-3)
    : Math.pow(0.01 / (curvature > slope ? curvature : slope), -method.exponent);
  return Math.min(100 * h, longer, span);
}

// y_old and F0, F1, F2 of the cubic between both ends of a step, in the rows of d.
function hermite(h, yOld, y, first, last, d) {
  for (let i = 0; i < y.length; i++) {
    const rise = y[i] - yOld[i];
    d[0][i] = yOld[i];
    d[1][i] = rise;
    d[2][i] = h * first[i] - rise;
    d[3][i] = 2 * rise - h * (last[i] + first[i]);
  }
}

function polynomial(d, x, out) {
  const last = d.length - 1;
  for (let i = 0; i < out.length; i++) {
    let total = d[last][i];
    for (let j = last; j > 0; j--) total = d[j - 1][i] + total * (j % 2 ? x : 1 - x);
    out[i] = total;
  }
  return out;
}

// Loops: each has advance(), which takes one step from run.t, run.y, and interpolate().
const LOOPS = {
  pair(run) {
    const { f, p, method, tf, rtol, atol } = run, n = run.y.length, s = method.stages;
    const k = rows(s + 1, n), u = zeros(n), error = zeros(n);
    let yOld = zeros(n), tOld = run.t, h = 0;
    run.nfev++;
    if (f(run.t, run.y, p, k[s])) return null;
    h = firstStep(run, k[s]);
    if (h !== h) return null;
    return {
      slope: k[s],
      advance() {
        const least = 10 * spacing(run.t);
        if (h < least) h = least;
        yOld.set(run.y);
        k[0].set(k[s]);
        tOld = run.t;
        for (let rejections = 0; ; rejections++) {
          if (h < least) return TOO_SMALL;
          const wanted = h;
          let t = tOld + h;
          if (t > tf) t = tf;
          h = t - tOld;
          run.nfev += s;
          if (method.step(f, tOld, h, yOld, p, k, u)) return RAISED;
          method.error(h, k, error);
          let total = 0;
          for (let i = 0; i < n; i++) {
            const a = Math.abs(yOld[i]), b = Math.abs(u[i]);
            const x = error[i] / (atol + (b > a || b !== b ? b : a) * rtol);
            total += x * x;
          }
          const norm = Math.sqrt(total / n);
          if (norm < 1) {
            let factor = SAFETY * Math.pow(norm, method.exponent);
            if (factor > MAX_FACTOR) factor = MAX_FACTOR;
            h *= rejections && factor > 1 ? 1 : factor;
            if (t === tf && h < wanted) h = wanted;
            run.rejected += rejections;
            run.t = t;
            run.y.set(u);
            return RUNNING;
          }
          const factor = SAFETY * Math.pow(norm, method.exponent);
          h *= factor > MIN_FACTOR ? factor : MIN_FACTOR;
          if (!(h >= least)) h = 0;
        }
      },
      interpolate() {
        const d = rows(4 + method.more, n), length = run.t - tOld;
        hermite(length, yOld, run.y, k[0], k[s], d);
        method.dense(length, k, d);
        return d;
      },
    };
  },

  single(run) {
    const { f, p, method, step: h } = run, n = run.y.length, s = method.stages;
    const k = rows(s + 1, n), u = zeros(n), yOld = zeros(n), start = run.t;
    run.nfev++;
    if (f(run.t, run.y, p, k[s])) return null;
    return {
      slope: k[s],
      advance() {
        yOld.set(run.y);
        k[0].set(k[s]);
        run.nfev += s;
        if (method.step(f, run.t, h, yOld, p, k, u)) return RAISED;
        run.t = start + (run.accepted + 1) * h;
        run.y.set(u);
        return RUNNING;
      },
      interpolate() {
        const d = rows(4, n);
        hermite(h, yOld, run.y, k[0], k[s], d);
        return d;
      },
    };
  },

  // Kicks and drifts of q'' = a(t, q), with compensated sums.
  kicks(run) {
    const { f, p, method, step: h } = run, n = run.y.length, m = n / 2, start = run.t;
    const { kicks, drifts, times } = method.table, s = drifts.length;
    const low = zeros(n), yOld = zeros(n), first = zeros(n), last = zeros(n);
    run.nfev++;
    if (f(run.t, run.y, p, last)) return null;
    function add(i, c, rate) {
      const part = low[i] + c * rate, total = run.y[i] + part;
      low[i] = part - (total - run.y[i]);
      run.y[i] = total;
    }
    return {
      advance() {
        const t = run.t;
        yOld.set(run.y);
        first.set(last);
        for (let i = 0; i < s; i++) {
          for (let j = m; j < n; j++) add(j, kicks[i] * h, last[j]);
          for (let j = 0; j < m; j++) add(j, drifts[i] * h, run.y[m + j]);
          run.nfev++;
          if (f(i < s - 1 ? t + times[i] * h : t + h, run.y, p, last)) return RAISED;
        }
        for (let j = m; j < n; j++) add(j, kicks[s] * h, last[j]);
        for (let j = 0; j < m; j++) last[j] = run.y[m + j];
        run.t = start + (run.accepted + 1) * h;
        return RUNNING;
      },
      interpolate() {
        const d = rows(4, n);
        hermite(h, yOld, run.y, first, last, d);
        return d;
      },
    };
  },

  // Implicit steps by fixed-point iteration, until no change decreases any more.
  stages(run) {
    const { f, p, method, step: h } = run, n = run.y.length, start = run.t;
    const { mu, ratio, b, c, rows: dense } = method.table, s = b.length;
    const weights = b.map((each) => h * each);
    weights[0] = weights[s - 1] = 0.5 * h - weights.slice(1, s / 2).reduce((a, x) => a + x, 0);
    const L = rows(n, s), Y = rows(n, s), low = zeros(n), yOld = zeros(n), u = zeros(n);
    const out = zeros(n), smallest = [zeros(n), zeros(n)], moved = zeros(s);
    run.nfev++;
    if (f(run.t, run.y, p, out)) return null;
    for (let k = 0; k < n; k++) for (let i = 0; i < s; i++) L[k][i] = weights[i] * out[k];
    function product(matrix, x) {
      for (let i = 0; i < s; i++) {
        let total = 0;
        for (let j = 0; j < s; j++) total += matrix[i][j] * x[j];
        moved[i] = total;
      }
      return moved;
    }
    function patience(k, count) {
      const rise = product(mu, L[k]);
      let change = 0;
      for (let i = 0; i < s; i++) {
        const next = run.y[k] + (low[k] + rise[i]);
        change = Math.max(change, Math.abs(next - Y[k][i]));
        Y[k][i] = next;
      }
      if (count === 0) return 100;
      if (change === 0) return 0;
      const before = smallest[count % 2];
      if (change < before[k]) {
        before[k] = change;
        return 100;
      }
      return change > 1e-6 * (Math.abs(Y[k][0]) + Math.abs(Y[k][s - 1])) ? 100 : 2;
    }
    return {
      advance() {
        smallest[0].fill(Infinity);
        smallest[1].fill(Infinity);
        for (let k = 0; run.accepted && k < n; k++) L[k].set(product(ratio, L[k]));
        for (let count = 0, stalls = 0; ; count++) {
          let most = 0;
          for (let k = 0; k < n; k++) most = Math.max(most, patience(k, count));
          stalls = most === 100 ? 0 : stalls + 1;
          if (stalls >= most) break;
          if (count === 100) return UNSOLVED;
          for (let i = 0; i < s; i++) {
            for (let k = 0; k < n; k++) u[k] = Y[k][i];
            run.nfev++;
            if (f(run.t + c[i] * h, u, p, out)) return RAISED;
            for (let k = 0; k < n; k++) L[k][i] = weights[i] * out[k];
          }
        }
        yOld.set(run.y);
        for (let k = 0; k < n; k++) {
          let rise = 0;
          for (let i = 0; i < s / 2; i++) rise += L[k][i] + L[k][s - 1 - i];
          rise += low[k];
          run.y[k] = yOld[k] + rise;
          low[k] = rise - (run.y[k] - yOld[k]);
        }
        run.t = start + (run.accepted + 1) * h;
        return RUNNING;
      },
      interpolate() {
        const d = rows(4, n);
        d[0].set(yOld);
        for (let r = 0; r < dense.length; r++) {
          for (let k = 0; k < n; k++) {
            for (let i = 0; i < s; i++) d[1 + r][k] += dense[r][i] * L[k][i];
          }
        }
        return d;
      },
    };
  },
};

// The zero of an event function in a step, by Brent's method as SciPy has it.
function crossing(value, a, b) {
  let fa = value(a), fb = value(b);
  if (fa === 0) return a;
  if (fb === 0) return b;
  if (fa > 0 === fb > 0) return Math.abs(fa) < Math.abs(fb) ? a : b;
  let c = a, fc = fa, step = b - a, previous = b - a;
  for (let n = 0; n < 100; n++) {
    if (Math.abs(fc) < Math.abs(fb)) {
      [a, b, c] = [b, c, b];
      [fa, fb, fc] = [fb, fc, fb];
    }
    const tolerance = 0.5 * (TOLERANCE + TOLERANCE * Math.abs(b)), middle = 0.5 * (c - b);
    if (fb === 0 || Math.abs(middle) <= tolerance) break;
    if (Math.abs(previous) < tolerance || Math.abs(fa) <= Math.abs(fb)) {
      step = previous = middle;
    } else {
      const s = fb / fa;
      let p, q;
      if (a === c) {
        p = 2 * middle * s;
        q = 1 - s;
      } else {
        const u = fa / fc, v = fb / fc;
        p = s * (2 * middle * u * (u - v) - (b - a) * (v - 1));
        q = (u - 1) * (v - 1) * (s - 1);
      }
      if (p > 0) q = -q;
      p = Math.abs(p);
      if (2 * p < Math.min(3 * middle * q - Math.abs(tolerance * q), Math.abs(previous * q))) {
        previous = step;
        step = p / q;
      } else {
        step = previous = middle;
      }
    }
    a = b;
    fa = fb;
    b += Math.abs(step) > tolerance ? step : middle > 0 ? tolerance : -tolerance;
    fb = value(b);
    if (fb > 0 === fc > 0) {
      c = a;
      fc = fa;
      step = previous = b - a;
    }
  }
  return b;
}

function changesSign(direction, before, after) {
  const up = before <= 0 && after >= 0, down = before >= 0 && after <= 0;
  return (up && direction >= 0) || (down && direction <= 0);
}

// One run with one function. `problem`: f, p, t, tf, y, method, rtol, atol, step, most, project,
// events [{of, direction, terminal}]. The result gets t, dense, events, counts, status.
function solveOne(problem) {
  const run = { ...problem, y: Float64Array.from(problem.y), nfev: 0, accepted: 0, rejected: 0 };
  const n = run.y.length, out = [0], at = zeros(n), { events, p, project } = problem;
  const result = { t: [run.t], y: [Float64Array.from(run.y)], dense: [], spans: [],
    found: events.map(() => []), ended: -1, status: RUNNING };
  const gather = (status) => Object.assign(result, { status, nfev: run.nfev,
    accepted: run.accepted, rejected: run.rejected });
  if (project) {
    if (project(run.t, run.y, p, at)) return gather(RAISED);
    run.y.set(at);
    result.y = [Float64Array.from(at)];
  }
  const loop = LOOPS[run.method.loop](run);
  if (!loop) return gather(RAISED);
  const of = (event, t, y) => (event.of(t, y, p, out) ? NaN : out[0]);
  let before = events.map((event) => of(event, run.t, run.y));
  while (run.t < run.tf) {
    if (run.accepted >= run.most) return gather(TOO_LONG);
    const tOld = run.t, status = loop.advance();
    if (status !== RUNNING) return gather(status);
    run.accepted++;
    if (run.method.fixed && Math.abs(run.t - run.tf) <= LANDED * run.step) run.t = run.tf;
    if (!run.y.every(Number.isFinite)) return gather(NOT_FINITE);
    if (project) {
      if (project(run.t, run.y, p, at)) return gather(RAISED);
      run.y.set(at);
      run.nfev++;
      if (run.f(run.t, run.y, p, loop.slope)) return gather(RAISED);
    }
    const h = run.t - tOld, d = loop.interpolate();
    let end = Math.min(run.t, run.tf);
    const reached = end === run.t ? run.y : polynomial(d, (end - tOld) / h, zeros(n));
    const after = events.map((event) => of(event, end, reached));
    const roots = [];
    events.forEach((event, i) => {
      const value = (t) => of(event, t, polynomial(d, (t - tOld) / h, at));
      const parts = run.method.fixed ? PARTS : 1; // RK45 has SciPy's events, at most one a step
      let from = tOld, first = before[i];
      for (let k = 1; k <= parts; k++) {
        const to = k < parts ? tOld + k * (end - tOld) / parts : end;
        const second = k < parts ? value(to) : after[i];
        if (k < parts && second === 0) continue;
        if (changesSign(event.direction, first, second)) {
          roots.push({ i, t: crossing(value, from, to) });
        }
        from = to;
        first = second;
      }
    });
    const cut = roots.filter(({ i }) => events[i].terminal).sort((a, b) => a.t - b.t || a.i - b.i)[0];
    for (const { i, t } of roots) {
      if (cut && (t > cut.t || (t === cut.t && i > cut.i))) continue;
      result.found[i].push({ t, y: onConstraints(polynomial(d, (t - tOld) / h, zeros(n)), t) });
    }
    before = after;
    if (cut) end = cut.t;
    result.dense.push(d);
    result.spans.push([tOld, h]);
    result.t.push(end);
    result.y.push(end === run.t ? Float64Array.from(run.y)
      : onConstraints(polynomial(d, (end - tOld) / h, zeros(n)), end));
    if (cut) {
      result.ended = cut.i;
      return gather(RUNNING);
    }
  }
  return gather(RUNNING);

  function onConstraints(y, t) {
    return project && !project(t, y, p, at) ? Float64Array.from(at) : y;
  }
}

// A run, in phases if the system has some. `asked`: variant, p, y0, tf, method, rtol, step, events.
function solve(asked) {
  const { variant, p, tf } = asked, begun = performance.now();
  const watched = asked.events.map((each) => ({ ...each, of: variant.events[each.index] }));
  const result = { t: [], y: [], dense: [], spans: [], nfev: 0, accepted: 0, rejected: 0,
    found: watched.map(() => []), phases: [], status: RUNNING, ended: -1 };
  let t = 0, y = asked.y0, name = -1;
  const next = zeros(y.length + 1);
  if (variant.phases) {
    if (variant.first(0, y, p, next)) return Object.assign(result, { status: RAISED });
    name = next[0];
    y = next.slice(1);
  }
  for (let count = 0; ; count++) {
    const phase = variant.phases ? variant.phases[name] : { f: variant.rhs };
    const own = phase.ends ? [{ of: phase.ends, direction: phase.direction, terminal: true }] : [];
    const part = solveOne({ ...asked, f: phase.f, t, y, atol: 1e-3 * asked.rtol,
      project: phase.project, events: [...own, ...watched], most: asked.most - result.accepted });
    for (const key of ["nfev", "accepted", "rejected"]) result[key] += part[key];
    for (const key of ["t", "y", "dense", "spans"]) {
      for (const one of part[key]) result[key].push(one);
    }
    part.found.slice(own.length).forEach((found, i) => result.found[i].push(...found));
    const end = part.t[part.t.length - 1];
    result.phases.push({ name, begin: t, end });
    result.status = part.status;
    if (part.status !== RUNNING || part.ended < 0) break;
    if (!own.length || part.ended > 0) {
      result.ended = part.ended - own.length;
      break;
    }
    const state = part.y[part.y.length - 1];
    if (phase.after(end, state, p, next)) { result.status = RAISED; break; }
    if (end >= tf) break;
    if (count > 10000) { result.status = TOO_LONG; break; }
    t = end;
    name = next[0];
    y = next.slice(1);
  }
  result.milliseconds = performance.now() - begun;
  result.message = SENTENCES[result.status] || "";
  result.at = evaluator(result, y.length);
  return result;
}

// The state at a time of a run, between its steps.
function evaluator(result, n) {
  const { spans, dense, y, t } = result;
  return (time, out = zeros(n)) => {
    if (!spans.length) return out.set(y[0]), out;
    let low = 0, high = spans.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (spans[middle][0] <= time) low = middle; else high = middle - 1;
    }
    const [begin, h] = spans[low];
    return polynomial(dense[low], (Math.min(time, t[t.length - 1]) - begin) / h, out);
  };
}

// The start of a system: its formulas, then Newton's iteration onto the constraints of a model.
function startOf(variant, p) {
  const y = zeros(variant.n);
  if (variant.start(0, y, p, y)) return null;
  for (const [part, first] of variant.settle || []) {
    if (!newton(part, y, p, first)) return null;
  }
  return y;
}

function newton({ of, count, free }, y, p, first) {
  const m = free.length, out = zeros(count * (m + 1));
  const residuals = (state) => (of(0, state, p, out) ? null : Array.from(out));
  const sizes = (found, state) => Array.from({ length: count }, (_, i) => {
    let size = Math.abs(found[i]);
    for (let j = 0; j < m; j++) size += Math.abs(found[count + i * m + j] * state[first + j]);
    return size;
  });
  const small = (found, state, share) => sizes(found, state).every(
    (size, i) => Math.abs(found[i]) <= share * size);
  const norm = (found) => Math.hypot(...found.slice(0, count));
  let found = residuals(y);
  for (let turn = 0; found && turn < 60 && !small(found, y, 1e-12); turn++) {
    const step = leastStep(found, count, m, free);
    let better = null;
    for (let k = 0; step && k < 8 && !better; k++) {
      const tried = y.slice();
      for (let j = 0; j < m; j++) tried[first + j] += step[j] * Math.pow(0.5, k);
      const there = residuals(tried);
      if (there && norm(there) < norm(found)) better = [tried, there];
    }
    if (!better) break;
    y.set(better[0]);
    found = better[1];
  }
  return found && small(found, y, 1e-9);
}

// The shortest step of the free components to the zero of linear residuals.
function leastStep(found, count, m, free) {
  const row = (i) => free.map((is, j) => (is ? found[count + i * m + j] : 0));
  const gram = [], right = [];
  for (let i = 0; i < count; i++) {
    gram.push(Array.from({ length: count }, (_, k) => dot(row(i), row(k))));
    right.push(-found[i]);
  }
  const shares = zeros(count), scale = Math.max(...gram.map((each, i) => each[i]));
  const left = gram.map((_, i) => i), used = [];
  while (left.length) { // elimination with pivots on the diagonal; rows that depend are left out
    left.sort((a, b) => gram[b][b] - gram[a][a]);
    const k = left.shift();
    if (!(gram[k][k] > 1e-20 * scale)) break;
    used.push(k);
    for (const i of left) {
      const share = gram[i][k] / gram[k][k];
      for (let j = 0; j < count; j++) gram[i][j] -= share * gram[k][j];
      right[i] -= share * right[k];
    }
  }
  for (const k of used.reverse()) {
    shares[k] = right[k];
    for (const j of used) if (j !== k) shares[k] -= gram[k][j] * shares[j];
    shares[k] /= gram[k][k];
  }
  return Array.from({ length: m }, (_, j) => dot(shares, used.length
    ? Array.from({ length: count }, (_, i) => row(i)[j]) : []));
}

function dot(a, b) {
  let total = 0;
  for (let i = 0; i < b.length; i++) total += a[i] * b[i];
  return total;
}
