/* MuJoCo's C library behind the driver: the parts of a step that compute each quantity, and nothing else. */
#include <mujoco/mujoco.h>

#include "driver.h"

static mjModel *model;
static mjData *data;
static mjtNum *force;

static void place(int s)
{
    memcpy(data->qpos, states[s], sizeof(mjtNum) * (size_t)model->nq);
    memcpy(data->qvel, states[s] + model->nq, sizeof(mjtNum) * (size_t)model->nv);
    mj_kinematics(model, data);
    mj_comPos(model, data);
}

static void run_mass(int s) { place(s), mj_makeM(model, data); }

static void bias(void)
{
    mj_comVel(model, data);
    mj_rne(model, data, 0, data->qfrc_bias);
}

static void run_bias(int s) { place(s), bias(); }
static void run_both(int s) { place(s), mj_makeM(model, data), bias(); }

static void run_forward(int s)
{
    const double *tau = states[s] + model->nq + model->nv;
    run_both(s);
    mj_factorM(model, data);
    for (int i = 0; i < model->nv; i++) force[i] = tau[i] - data->qfrc_bias[i];
    mj_solveM(model, data, data->qacc, force, 1);
}

static int fetch_mass(double *out)
{
    mj_fullM(model, data, out);
    return (int)(model->nv * model->nv);
}
static int fetch_bias(double *out)
{
    memcpy(out, data->qfrc_bias, sizeof(double) * (size_t)model->nv);
    return (int)model->nv;
}
static int fetch_both(double *out)
{
    int count = fetch_mass(out);
    return count + fetch_bias(out + count);
}
static int fetch_forward(double *out)
{
    memcpy(out, data->qacc, sizeof(double) * (size_t)model->nv);
    return (int)model->nv;
}

int main(int count, char **arguments)
{
    static const task tasks[] = {
        { "mass", run_mass, fetch_mass },
        { "bias", run_bias, fetch_bias },
        { "both", run_both, fetch_both },
        { "forward", run_forward, fetch_forward },
    };
    if (count != 3) return 2;
    model = mj_loadModel(arguments[2], 0);
    if (!model) { fprintf(stderr, "%s: no model of this version\n", arguments[2]); return 2; }
    data = mj_makeData(model);
    force = (mjtNum *)malloc(sizeof(mjtNum) * (size_t)model->nv);
    read_states(arguments[1], (int)(model->nq + 2 * model->nv));
    return serve(tasks, sizeof tasks / sizeof *tasks);
}
