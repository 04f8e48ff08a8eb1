"""Reference for `van_der_pol_agrees_with_scipy`: y'' = 5 (1 - y^2) y' - y, y(0) = 2."""
from scipy.integrate import solve_ivp

for method in ("DOP853", "Radau"):
    tight = {"rtol": 1e-13, "atol": 1e-14} if method == "DOP853" else {"rtol": 1e-12, "atol": 1e-13}
    y = solve_ivp(lambda t, y: [y[1], 5 * (1 - y[0] ** 2) * y[1] - y[0]], (0, 20), [2, 0],
                  method=method, **tight).y[:, -1]
    print(method, *map(repr, y.tolist()))
