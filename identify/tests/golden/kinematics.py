"""Golden numbers for the smoothing module, by NumPy and SciPy.

Writes kinematics.json beside this file:
- savgol: scipy.signal.savgol_filter (mode="interp") of one signal;
- smoother: the posterior of a Wiener process of order N - 1 under noise, at
  irregular times, by dense Gaussian conditioning. The joint covariance of all
  states is built from matrix exponentials (Van Loan), not by a recursion.

Run: python3 kinematics.py  (NumPy >= 2, SciPy >= 1.14)
"""

import json
import pathlib

import numpy as np
from scipy.linalg import expm
from scipy.signal import savgol_filter


def savgol():
    rng = np.random.default_rng(3)
    t = 0.005 * np.arange(70)
    x = np.sin(7 * t) + 0.3 * np.cos(31 * t) + 0.01 * rng.standard_normal(t.size)
    cases = []
    for window, order in [(31, 4), (7, 4), (15, 2)]:
        for derivative in (0, 1, 2):
            y = savgol_filter(x, window, order, deriv=derivative, delta=0.005, mode="interp")
            cases.append({"window": window, "order": order, "derivative": derivative, "y": list(y)})
    return {"step": 0.005, "x": list(x), "cases": cases}


def transition(n, h, w):
    """F and Q of d^n q/dt^n = white noise of density w over a step h."""
    a = np.diag(np.ones(n - 1), 1)
    g = np.zeros((n, n))
    g[-1, -1] = w
    e = expm(np.block([[-a, g], [np.zeros((n, n)), a.T]]) * h)
    f = e[n:, n:].T
    return f, f @ e[:n, n:]


def smoother(n, seed):
    rng = np.random.default_rng(seed)
    t = np.sort(rng.uniform(0, 2, 45))
    t[0] = 0.0
    truth = [np.sin(3 * t), 3 * np.cos(3 * t), -9 * np.sin(3 * t)]
    sd = [0.01, 0.2, 2.0]
    w = {3: 900.0, 4: 9000.0, 5: 90000.0}[n]
    prior_sd = [2.0, 5.0, 20.0, 80.0, 300.0][:n]
    z = [x + s * rng.standard_normal(t.size) for x, s in zip(truth, sd)]
    channels = {"q": [0], "q_dq": [0, 1], "q_dq_ddq": [0, 1, 2]}
    m = t.size
    # All states are linear in the independent draws: initial state and steps.
    mean = np.zeros((m, n))
    mean[0, 0] = z[0][0]
    cov = np.zeros((m * n, m * n))
    block = lambda i: slice(i * n, (i + 1) * n)
    cov[block(0), block(0)] = np.diag(np.square(prior_sd))
    for k in range(1, m):
        f, q = transition(n, t[k] - t[k - 1], w)
        mean[k] = f @ mean[k - 1]
        past = slice(0, k * n)
        cov[block(k), past] = f @ cov[block(k - 1), past]
        cov[past, block(k)] = cov[block(k), past].T
        cov[block(k), block(k)] = f @ cov[block(k - 1), block(k - 1)] @ f.T + q
    result = {"order": n, "t": list(t), "sd": sd, "w": w, "prior_sd": prior_sd,
              "z": [list(x) for x in z], "cases": []}
    for name, used in channels.items():
        rows = [k * n + i for k in range(m) for i in used]
        noise = np.array([sd[i] ** 2 for _ in range(m) for i in used])
        data = np.array([z[i][k] for k in range(m) for i in used])
        s = cov[np.ix_(rows, rows)] + np.diag(noise)
        residual = data - mean.ravel()[rows]
        solve = np.linalg.solve(s, residual)
        gain = np.linalg.solve(s, cov[rows]).T
        posterior = (mean.ravel() + gain @ residual).reshape(m, n)
        spread = np.sqrt(np.diag(cov - gain @ cov[rows])).reshape(m, n)
        evidence = -0.5 * (residual @ solve + np.linalg.slogdet(2 * np.pi * s)[1])
        result["cases"].append({
            "channels": name, "log_likelihood": evidence,
            "q": list(posterior[:, 0]), "v": list(posterior[:, 1]), "a": list(posterior[:, 2]),
            "sd_q": list(spread[:, 0]), "sd_v": list(spread[:, 1]), "sd_a": list(spread[:, 2]),
        })
    return result


if __name__ == "__main__":
    golden = {"savgol": savgol(), "smoother": [smoother(3, 1), smoother(4, 2), smoother(5, 3)]}
    path = pathlib.Path(__file__).with_name("kinematics.json")
    path.write_text(json.dumps(golden) + "\n")
