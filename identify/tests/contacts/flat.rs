//! Discs that lie flat on a plane, or nearly: there every point of the rim is as low as any other.

use crate::case::Case;

/// Radius of the coin, m.
const R: f64 = 0.03;
/// Within this of flat a disc is domed, rad (`docs/model-language.md`).
const FLAT: f64 = 0.01;

/// A thin disc whose angles are regular where it lies flat.
fn coin() -> Case {
    Case::new(
        "
        model coin;
        coordinate x: m;
        coordinate y: m;
        coordinate z: m;
        coordinate a: rad;
        coordinate b: rad;
        coordinate c: rad;
        body coin {
            frame: translate(x, y, z) * rotate_x(a) * rotate_y(b) * rotate_z(c);
            mass: 0.02; inertia: diag(4.5e-6, 4.5e-6, 9e-6);
        }
        gravity (0, 0, -9.81);
        contact rim: disc_z(coin, 0.03) on plane_z(world) { friction: 0.4; }
        ",
    )
}

/// A rim outside of `FLAT`; within, a dome that joins it and bulges by half of `FLAT R`. Rates are those of the gap.
#[test]
fn a_disc_is_domed_within_a_hundredth_of_flat() {
    let case = coin();
    let at = |tilt: f64, v: &[f64]| case.contacts(0.0, &[0.0, 0.0, 0.1, tilt, 0.0, 0.0], v);
    for tilt in [0.0_f64, 1e-9, 1e-3, -5e-3, 0.0099, 0.0101, 0.1, -1.2] {
        let s = tilt.sin().abs();
        let reach = match s < FLAT {
            true => R * (s * s + FLAT * FLAT) / (2.0 * FLAT),
            false => R * s,
        };
        let rate = 0.7;
        let v = [0.0, 0.0, 0.0, rate, 0.0, 0.0];
        let here = at(tilt, &v);
        assert!(
            (here.gap[0] - (0.1 - reach)).abs() < 1e-15,
            "{tilt}: {}",
            here.gap[0]
        );
        let h = 1e-7;
        let moved = (at(tilt + h, &v).gap[0] - at(tilt - h, &v).gap[0]) / (2.0 * h) * rate;
        assert!(
            (here.approach(0) - moved).abs() < 1e-8,
            "{tilt}: {moved}, {}",
            here.approach(0)
        );
        let most = R * rate * rate / FLAT;
        assert!(here.bias.amax() <= 1.01 * most, "{tilt}: {}", here.bias);
    }
}

/// It clatters and loses energy. Where the lowest point of the rim leapt from one side to the other, it flew up.
#[test]
fn a_coin_that_falls_nearly_flat_gains_nothing() {
    let case = coin();
    let thrown = [
        (0.001, 0.0, 0.5),
        (0.001, 1e-4, 0.5),
        (0.01, 1e-2, 0.5),
        (0.01, 0.1, 0.5),
        (0.001, 0.0, 5.0),
    ];
    let steps = [1e-4, 1e-3, 5e-3];
    let all = thrown
        .into_iter()
        .flat_map(|thrown| steps.map(|h| (thrown, h)));
    for ((z, tilt, rate), h) in all {
        let q = [0.0, 0.0, z, tilt, 0.0, 0.0];
        let v = [0.0, 0.0, 0.0, 0.0, rate, 0.0];
        let before = case.energy(&q, &v);
        let mut most = 0.0_f64;
        let end = case.run((&q, &v), h, (0.5 / h) as usize, |_, q, v, _| {
            most = most.max(case.energy(q, v));
        });
        let after = case.energy(&end.q, &end.v);
        assert!(
            most < 1.001 * before,
            "{tilt}, {rate}, {h}: {most} J of {before} J"
        );
        assert!(
            after < 0.9 * before,
            "{tilt}, {rate}, {h}: {after} J of {before} J"
        );
    }
}

/// Let go flat, it stays.
#[test]
fn a_coin_lies_flat() {
    let case = coin();
    let lies = R * FLAT / 2.0;
    let end = case.run(
        (&[0.0, 0.0, lies, 0.0, 0.0, 0.0], &[0.0; 6]),
        1e-3,
        500,
        |_, _, _, _| (),
    );
    assert!((end.q[2] - lies).abs() < 1e-9, "{:?}", end.q);
    assert!(end.v.iter().all(|v| v.abs() < 1e-9), "{:?}", end.v);
}
