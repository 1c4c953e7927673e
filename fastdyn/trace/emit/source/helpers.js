// To the nearest whole number, halves to even ones.
function rint(x) {
  if (!(Math.abs(x) < 4503599627370496)) return x;
  const low = Math.floor(x), part = x - low;
  const whole = part < 0.5 || (part === 0.5 && low % 2 === 0) ? low : low + 1;
  return whole === 0 && (x < 0 || Object.is(x, -0)) ? -0 : whole;
}

// As in C: 1 to any power is 1, and -1 to an infinite power is 1.
function pow(x, e) {
  return x === 1 || (x === -1 && Math.abs(e) === Infinity) ? 1 : Math.pow(x, e);
}

// The series of M. Abramowitz and I. A. Stegun, 7.1.6; beyond 2, 1 - erfc.
function erf(x) {
  if (!(Math.abs(x) < 2)) return x < 0 ? erfc(-x) - 1 : 1 - erfc(x);
  let term = x, sum = x;
  for (let n = 1; Math.abs(term) > 1e-17 * Math.abs(sum); n++) {
    term *= 2 * x * x / (2 * n + 1);
    sum += term;
  }
  return 2 / Math.sqrt(Math.PI) * Math.exp(-x * x) * sum;
}

// The continued fraction of M. Abramowitz and I. A. Stegun, 7.1.14, from its 200th term on.
function erfc(x) {
  if (x !== x) return x;
  if (x < 2) return 1 - erf(x);
  let fraction = 0;
  for (let n = 200; n > 0; n--) fraction = 0.5 * n / (x + fraction);
  return Math.exp(-x * x) / ((x + fraction) * Math.sqrt(Math.PI));
}

// C. Lanczos, SIAM J. Numer. Anal. B 1 (1964), with g = 7 and 9 terms.
function lanczos(x) {
  const c = [0.99999999999980993, 676.5203681218851, -1259.1392167224028, 771.32342877765313,
    -176.61502916214059, 12.507343278686905, -0.13857109526572012, 9.9843695780195716e-6,
    1.5056327351493116e-7];
  return c.reduce((sum, each, i) => (i ? sum + each / (x + i) : each), 0);
}

function tgamma(x) {
  if (x < 0.5) return Math.PI / (Math.sin(Math.PI * x) * tgamma(1 - x));
  if (x < 21 && x % 1 === 0) {
    let whole = 1;
    for (let n = 2; n < x; n++) whole *= n;
    return whole;
  }
  const t = x + 6.5, half = Math.pow(t, 0.5 * (x - 0.5));
  return Math.sqrt(2 * Math.PI) * half * Math.exp(-t) * half * lanczos(x - 1);
}

function lgamma(x) {
  if (x < 0.5) return Math.log(Math.abs(Math.PI / Math.sin(Math.PI * x))) - lgamma(1 - x);
  const t = x + 6.5;
  return 0.5 * Math.log(2 * Math.PI) + (x - 0.5) * Math.log(t) - t + Math.log(lanczos(x - 1));
}

function entry_of(n, tables, x) {
  let i = Math.abs(x) < 4e18 ? Math.trunc(x) : 0;
  if (i < 0) i += n;
  return tables[0][Math.min(Math.max(i, 0), n - 1)];
}

function search_left(n, tables, x) {
  let low = 0, high = n;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (!(tables[0][middle] >= x)) low = middle + 1; else high = middle;
  }
  return low;
}

function search_right(n, tables, x) {
  let low = 0, high = n;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (!(tables[0][middle] > x)) low = middle + 1; else high = middle;
  }
  return low;
}

// The index of the piece that contains x.
function piece_of(n, tables, x) {
  return Math.min(Math.max(search_right(n, tables, x) - 1, 0), n - 2);
}

function piecewise(n, tables, x) {
  const i = piece_of(n, tables, x), at = x - tables[0][i];
  let result = tables[1][i];
  for (let k = 2; k < tables.length; k++) result = result * at + tables[k][i];
  return result;
}

function interpolate(n, tables, x) {
  const [knots, heights] = tables, i = piece_of(n, tables, x);
  const left = knots[i], right = knots[i + 1], low = heights[i], high = heights[i + 1];
  if (x !== x) return x;
  if (x === left) return low;
  const slope = (high - low) / (right - left);
  let result = slope * (x - left) + low;
  if (result !== result) result = slope * (x - right) + high;
  return result !== result && low === high ? low : result;
}

// The factors of a matrix, in place by rows; n rows that were exchanged and n sizes follow.
function factorise(n, scaled, a) {
  for (let i = 0; i < n; i++) {
    let size = 1;
    if (scaled) {
      size = 0;
      for (let j = 0; j < n; j++) size = Math.max(size, Math.abs(a[i * n + j]));
      for (let j = 0; j < n; j++) a[i * n + j] /= size;
    }
    a[n * n + n + i] = size;
  }
  for (let k = 0; k < n; k++) {
    let best = k;
    for (let i = k + 1; i < n; i++) {
      if (Math.abs(a[i * n + k]) > Math.abs(a[best * n + k])) best = i;
    }
    a[n * n + k] = best;
    for (let j = 0; best !== k && j < n; j++) {
      const moved = a[k * n + j];
      a[k * n + j] = a[best * n + j];
      a[best * n + j] = moved;
    }
    for (let i = k + 1; i < n; i++) {
      const share = a[i * n + k] /= a[k * n + k];
      if (share !== 0) for (let j = k + 1; j < n; j++) a[i * n + j] -= share * a[k * n + j];
    }
  }
  return a;
}

function is_singular(n, scaled, a) {
  const least = scaled ? n * Number.EPSILON : 0;
  for (let k = 0; k < n; k++) if (Math.abs(a[k * n + k]) <= least) return true;
  return false;
}

// The solution for a right-hand side, which is overwritten.
function solved(n, transposed, a, b) {
  for (let i = 0; !transposed && i < n; i++) b[i] /= a[n * n + n + i];
  for (let k = 0; !transposed && k < n; k++) {
    const best = a[n * n + k], moved = b[k];
    b[k] = b[best];
    b[best] = moved;
  }
  for (let k = 0; k < n; k++) {
    for (let j = 0; j < k; j++) b[k] -= (transposed ? a[j * n + k] : a[k * n + j]) * b[j];
    if (transposed) b[k] /= a[k * n + k];
  }
  for (let k = n - 1; k >= 0; k--) {
    for (let j = k + 1; j < n; j++) b[k] -= (transposed ? a[j * n + k] : a[k * n + j]) * b[j];
    if (!transposed) b[k] /= a[k * n + k];
  }
  for (let k = n - 1; transposed && k >= 0; k--) {
    const best = a[n * n + k], moved = b[k];
    b[k] = b[best];
    b[best] = moved;
  }
  for (let i = 0; transposed && i < n; i++) b[i] /= a[n * n + n + i];
  return b;
}
