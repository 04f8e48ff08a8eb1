mod support;
use dynamics_codegen::tree::*;
use std::time::Instant;
use support::*;
#[test]
fn all() {
    for name in [
        "iiwa7",
        "kuka_iiwa14_pybullet",
        "panda",
        "ur5_robot",
        "ur10_robot",
        "solo12",
        "anymal_c",
        "trifinger_edu",
        "two_link_robot",
        "cartpole",
    ] {
        for float in [false, true] {
            let robot =
                urdf_rs::read_file(shared(&format!("data/urdf/{name}.urdf")).unwrap()).unwrap();
            let mut l = load(&robot, None);
            if float {
                let n = l.tree.coordinates;
                let g = &mut l.graph;
                let mut c = |k: usize| {
                    let q = g.symbol("fq");
                    let v = g.symbol("fv");
                    Coordinate {
                        q: g.var(q),
                        v: g.var(v),
                        index: n + k,
                        ratio: 1.0,
                    }
                };
                let all: Vec<_> = (0..7).map(&mut c).collect();
                l.tree.coordinates += 7;
                l.tree.bodies[0].joint = Joint::Floating(Floating {
                    position: all[..3].try_into().unwrap(),
                    quaternion: all[3..].try_into().unwrap(),
                });
            }
            let t = Instant::now();
            let g = &mut l.graph;
            let m = match Mechanism::new(g, &l.tree, Options::default()) {
                Ok(m) => m,
                Err(e) => {
                    println!("{name}: {e}");
                    continue;
                }
            };
            let t0 = t.elapsed();
            let mm = m.mass_matrix(g).concat();
            let b = m.bias_force(g);
            let z = vec![g.zero(); l.tree.coordinates];
            let f = m.forward_dynamics(g, &z);
            let t1 = t.elapsed();
            let d = m.inverse_dynamics_derivatives(g, &z);
            let d = [d.position.concat(), d.velocity.concat()].concat();
            let t2 = t.elapsed();
            let fd = m.forward_dynamics_derivatives(g, &z);
            let fd = [
                fd.position.concat(),
                fd.velocity.concat(),
                fd.force.concat(),
            ]
            .concat();
            let t3 = t.elapsed();
            println!(
                "{name} float={float} n={} layout {:?} M {} bias {} both {} FD {} dID {} dFD {}  {:?} {:?} {:?} {:?} snapped {} regrouped {}",
                l.tree.coordinates,
                m.report().layout,
                g.operation_count(&mm),
                g.operation_count(&b),
                g.operation_count(&[mm.clone(), b.clone()].concat()),
                g.operation_count(&f),
                g.operation_count(&d),
                g.operation_count(&fd),
                t0,
                t1,
                t2,
                t3,
                m.report().snapped.len(),
                m.report().regrouped.len()
            );
        }
    }
}
