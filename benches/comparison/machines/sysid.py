"""MuJoCo's sysid: multiple shooting over the log, with everything free that its joints and bodies have.

A user who does not know what is missing frees what may be: damping, dry friction, armature and a spring of every joint,
the mass of every link, and a delay of the inputs. Bounds are from the sizes in the log, as one would set them by hand.
"""

import contextlib
import io

import mujoco
import mujoco.rollout
import numpy as np
from mujoco import sysid

from machines import scoring
from machines.answer import Answer, clock, number

FINER = 2
"""Steps of MuJoCo's per sample of the log, by the Runge-Kutta method: with these its model predicts as the others' do."""
SHOOTING = 1.0
"""Length of the pieces that are predicted in the identification, s."""
ITERATIONS = 40
MOVED = 0.01
"""What is mentioned of a parameter: moves by this share of its bounds, and more."""


def description(machine):
    """The machine's model as an MJCF or URDF, which its user has."""
    p = machine.nominal
    if machine.system.name == "planar_arm":
        return mujoco.MjSpec.from_file(str(machine.folder / "model.urdf"))
    if machine.system.name == "cartpole":
        bodies = f"""<body name="cart"><joint name="x" type="slide" axis="1 0 0"/>
          <inertial pos="0 0 0" mass="{p['mc']}" diaginertia="1 1 1"/>
          <body name="pole"><joint name="theta" axis="0 -1 0"/>
            <inertial pos="0 0 {-p['l']}" mass="{p['mp']}" diaginertia="{p['I']} {p['I']} {p['I']}"/></body></body>"""
    else:
        bodies = ""
        for i in (2, 1):
            place = f'pos="0 0 {-p["l1"]}"' if i == 2 else ""
            inertia = " ".join([str(p[f"I{i}"])] * 3)
            bodies = f"""<body name="link{i}" {place}><joint name="j{i}" axis="0 -1 0"/>
              <inertial pos="0 0 {-p[f"lc{i}"]}" mass="{p[f"m{i}"]}" diaginertia="{inertia}"/>{bodies}</body>"""
    return mujoco.MjSpec.from_string(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")


def prepare(machine):
    """The description with motors, sensors of positions, and steps."""
    spec = description(machine)
    spec.option.timestep = 1 / machine.simulated.rate / FINER
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    for name in machine.system.inputs:
        spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    for name in machine.system.coords:
        spec.add_sensor(name=name, type=mujoco.mjtSensor.mjSENS_JOINTPOS, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname=name)
    return spec


def identify(spec, joints, bodies, train):
    """Identified parameters, what they were, their intervals, and the model."""
    # a user writes this
    model = spec.compile()
    force, speed, reach = train.u.std(), train.v.std(axis=0), train.q.std(axis=0)
    params = sysid.ParameterDict()

    def free(name, value, low, high, write):
        params.add(sysid.Parameter(name, value, low, high, modifier=lambda spec, p: write(spec, p.value[0])))

    for i, joint in enumerate(joints):
        def of(key, joint=joint, series=False):
            return lambda spec, x: setattr(spec.joint(joint), key, [x, 0, 0] if series else x)

        free(f"{joint} damping", 0, 0, force / speed[i], of("damping", series=True))
        free(f"{joint} frictionloss", 0, 0, force, of("frictionloss"))
        free(f"{joint} armature", 0, 0, model.body_inertia.max() + model.body_mass.max() / 10, of("armature"))
        free(f"{joint} stiffness", 0, 0, 3 * force / reach[i], of("stiffness", series=True))
        free(f"{joint} springref", 0, -3 * reach[i], 3 * reach[i], of("springref"))
    for body in bodies:
        mass = float(model.body(body).mass[0])
        free(f"{body} mass", mass, 0.5 * mass, 2 * mass, lambda spec, x, body=body: setattr(spec.body(body), "mass", x))
    params.add(sysid.Parameter("delay", 0, 0, 0.05))
    whole = sysid.TimeSeries(train.log.t, train.log.u)
    starts, count = train.starts(SHOOTING, SHOOTING)
    pieces = [slice(s, s + count + 1) for s in starts]
    states = [sysid.create_initial_state(model, train.q[s], train.v[s]) for s in starts]
    # Positions as states: what sensors of a rollout show is one step older than its times say.
    measured, positions = train.log.q[train.half:], [f"{joint}_qpos" for joint in joints]
    sequences = sysid.ModelSequences(
        "machine", spec, [f"piece{s}" for s in starts], states,
        [sysid.TimeSeries(train.t[p] - train.t[p.start], train.u[p]) for p in pieces],
        [sysid.TimeSeries.from_names(train.t[p] - train.t[p.start], measured[p], model, positions) for p in pieces])
    # Inputs are delayed from the whole log: at a piece's start, those from before it still act. Steps hold what
    # the log says in their middle.
    begin = {np.asarray(state).tobytes(): t for state, t in zip(states, train.t[starts])}

    def delayed(models, datas, control_signal, initial_states, param_dicts, **mappings):
        start = begin[np.asarray(initial_states[0]).tobytes()]
        late = [sysid.TimeSeries(c.times, whole.resample(c.times + start + spec.option.timestep / 2 - p["delay"].value[0]).data)
                for c, p in zip(control_signal, param_dicts)]
        return sysid.sysid_rollout(models=models, datas=datas, control_signal=late, initial_states=initial_states, **mappings)

    residual = sysid.build_residual_fn(models_sequences=[sequences], custom_rollout=delayed, n_threads=1)
    before = params.as_vector()
    params.move_off_bounds()
    params, result = sysid.optimize(params, residual, verbose=False, max_iters=ITERATIONS)
    _, intervals = sysid.calculate_intervals(residual(result.x, params)[0], result.jac)
    # up to here
    return params, before, intervals


def predict(machine, task, spec, params):
    """Predictions of the identified model."""
    model = sysid.apply_param_modifiers(params, spec)
    starts, count = task.starts()
    shift = params["delay"].value[0] if "delay" in params else 0.0
    found = []
    for s in starts:
        times = task.t[s] + (np.arange(count * FINER) + 0.5) * model.opt.timestep - shift
        control = np.column_stack([np.interp(times, task.log.t, column) for column in task.log.u.T])
        state = sysid.create_initial_state(model, task.q[s], task.v[s])
        states, _ = mujoco.rollout.rollout(model, mujoco.MjData(model), state, control)
        q = states[0][:, 1:1 + model.nq]
        found.append(np.vstack([task.q[s], q[FINER - 1::FINER]]))
    return np.stack(found)


def answer(machine, train, task):
    """The answer of MuJoCo's sysid."""
    spec = prepare(machine)
    bodies = ["cart", "pole"] if machine.system.name == "cartpole" else [f"link{i + 1}" for i in range(machine.system.links)]
    with clock() as spent, contextlib.redirect_stdout(io.StringIO()):
        params, before, intervals = identify(spec, machine.system.coords, bodies, train)
    error = scoring.error(task, predict(machine, task, prepare(machine), params))
    return Answer("MuJoCo sysid", error, spent[0], said(params, before, intervals))


def said(params, before, intervals):
    """Parameters that have moved most, as a share of what their bounds allow, with their intervals."""
    low, high = params.get_bounds()
    values = params.as_vector()
    moved = sorted(zip(abs(values - before) / (high - low), params.keys(), values, intervals), reverse=True)
    moved = [m for m in moved if m[0] > MOVED]
    shown = ", ".join(f"{name} {number(value)} ± {number(interval)}" for _, name, value, interval in moved[:5])
    return (shown or "nothing") + (f" and {len(moved) - 5} more" if len(moved) > 5 else "")
