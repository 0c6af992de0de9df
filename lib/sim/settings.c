/* What may be another between two steps: the user pointer, coefficients, controls, and the options
 * that size nothing. The method first makes its memory independent of how it came to the state
 * under the old ones (settle), then looks at the new ones (prepare). */
#include <math.h>
#include <string.h>

#include "errors.h"
#include "sim_impl.h"

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_set_user, (nsdae_sim * sim, void *user), sim, user)
{
  nsdae_error_clear(&sim->error);
  if (sim->system->maker.of)
    return nsdae_error_set(&sim->error, NSDAE_E_STATE, "nsdae_sim_set_user", "user",
                           "the callbacks are those of nsdae_bodies: give each load, drive or user "
                           "row a user pointer of its own");
  sim->stage.waiting = 0;
  sim->model.user = user;
  return NSDAE_OK;
}

/* Before anything is changed. */
static int check_change(nsdae_sim *sim)
{
  nsdae_result *r = &sim->next->result;
  nsdae_memory *memory = &sim->now->result.memory;
  const nsdae_state state = {.terms = &sim->now->result.end, .memory = memory};
  sim->stage.waiting = 0;
  if (!sim->stage.started || !sim->method->settle || memory->stamp == 0) return NSDAE_OK;
  sim->stage.between = 0;
  int status;
  do {
    nsdae_result_clear(r);
    nsdae_memory_copy(&r->memory, memory);
    nsdae_stepper_count(&sim->stepper, &state, r);
    status = sim->method->settle(sim->own, &state, r);
  } while (status == NSDAE_ARRAYS_GROW && (status = nsdae_sim_grow(sim)) == NSDAE_OK);
  if (status < 0) return status;
  nsdae_memory_copy(memory, &r->memory);
  memory->stamp = -1; /* what is kept beside it was made under the old settings */
  return NSDAE_OK;
}

/* Forces jump at the state: event finds its modes anew. */
static void jump(nsdae_sim *sim)
{
  if (sim->method->jump) sim->method->jump(sim->own, &sim->now->result.memory);
}

static int prepare_method(nsdae_sim *sim)
{
  nsdae_stepper_prepare(&sim->stepper);
  return sim->method->prepare ? sim->method->prepare(sim->own) : NSDAE_OK;
}

/* A setting of this size becomes another one, if the method takes it. */
static int change(nsdae_sim *sim, void *setting, const void *to, void *before, size_t size)
{
  int status = check_change(sim);
  if (status < 0) return status;
  memcpy(before, setting, size);
  memcpy(setting, to, size);
  status = prepare_method(sim);
  if (status == NSDAE_OK) return status;
  const nsdae_error why = sim->error;
  memcpy(setting, before, size);
  prepare_method(sim);
  sim->error = why;
  return status;
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_set_options,
               (nsdae_sim * sim, const nsdae_sim_options *options), sim, options)
{
  static const char *const fixed[] = {"method", "polygon", "projection", "threads"};
  nsdae_sim_options before;
  nsdae_error_clear(&sim->error);
  if (!options)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_set_options", "options",
                           "options is NULL");
  int status = nsdae_sim_options_check(options, &sim->error);
  for (size_t i = 0; i < sizeof fixed / sizeof *fixed && status == NSDAE_OK; i++) {
    const nsdae_param *p = nsdae_params_find(nsdae_sim_options_table(), fixed[i]);
    if (nsdae_sim_option_value(options, p) == nsdae_sim_option_value(&sim->options, p)) continue;
    status = nsdae_error_set(
        &sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_set_options", fixed[i],
        "%s is fixed after nsdae_sim_create: create another simulation for another %s", fixed[i],
        fixed[i]);
  }
  if (status == NSDAE_OK) status = change(sim, &sim->options, options, &before, sizeof before);
  if (status == NSDAE_OK && sim->stage.started && before.dt != options->dt) {
    /* A new dt starts a new grid of steps where the run is. */
    sim->now->accounts.grid_start = sim->now->result.end.t;
    sim->now->accounts.grid_count = 0;
  }
  return status;
}

/* Of a contact or a frictional joint. */
static int bad_coefficient(nsdae_sim *sim, const char *where, const char *name, int kind, int i,
                           double value, const char *range)
{
  nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, name,
                  "%s = %g is outside its range: it must be %s", name, value, range);
  nsdae_system_name_item(sim->system, kind, i, &sim->error);
  return NSDAE_E_ARGUMENT;
}

static int bad_index(nsdae_sim *sim, const char *where, const char *name, int i, int n)
{
  nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, name,
                  "%s = %d is outside its range: there are %d", name, i, n);
  return nsdae_error_at(&sim->error, NSDAE_E_ARGUMENT, i, NAN);
}

/* mu sizes the problem where it is zero in the system: those stay without friction. */
static int check_mu(nsdae_sim *sim, const char *where, int kind, int i, double made, double mu)
{
  if (!(mu >= 0) || isinf(mu))
    return bad_coefficient(sim, where, "mu", kind, i, mu, "at least 0, finite");
  if (made == 0 && mu > 0)
    return bad_coefficient(sim, where, "mu", kind, i, mu, "0, as in the system of the simulation");
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_set_contact,
               (nsdae_sim * sim, int i, double mu, double e_n, double e_t), sim, i, mu, e_n, e_t)
{
  const char *where = "nsdae_sim_set_contact";
  nsdae_error_clear(&sim->error);
  if (i < 0 || i >= sim->system->dims.k) return bad_index(sim, where, "i", i, sim->system->dims.k);
  int status = check_mu(sim, where, NSDAE_NAME_CONTACT, i, sim->system->contact[i].mu, mu);
  if (status < 0) return status;
  if (!(e_n >= 0 && e_n <= 1))
    return bad_coefficient(sim, where, "e_n", NSDAE_NAME_CONTACT, i, e_n, "0 to 1");
  if (!(e_t >= 0 && e_t <= 1))
    return bad_coefficient(sim, where, "e_t", NSDAE_NAME_CONTACT, i, e_t, "0 to 1");
  const nsdae_coefficients to = {mu, e_n, e_t, 1};
  nsdae_coefficients before;
  status = change(sim, &sim->model.contact[i], &to, &before, sizeof to);
  if (status == NSDAE_OK) jump(sim);
  return status;
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_set_frictional_joint, (nsdae_sim * sim, int j, double mu), sim,
               j, mu)
{
  const char *where = "nsdae_sim_set_frictional_joint";
  nsdae_error_clear(&sim->error);
  if (j < 0 || j >= sim->model.dims.f) return bad_index(sim, where, "j", j, sim->model.dims.f);
  int status =
      check_mu(sim, where, NSDAE_NAME_FRICTIONAL_JOINT, j, sim->system->frictional_joint[j].mu, mu);
  if (status == NSDAE_OK && mu == 0 && sim->system->frictional_joint[j].mu > 0)
    status = bad_coefficient(sim, where, "mu", NSDAE_NAME_FRICTIONAL_JOINT, j, mu,
                             "above 0, as in the system of the simulation");
  if (status == NSDAE_OK) status = check_change(sim);
  if (status < 0) return status;
  jump(sim);
  sim->model.frictional_joint[j].mu = mu;
  return prepare_method(sim);
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_set_friction_bound, (nsdae_sim * sim, int j, double bound),
               sim, j, bound)
{
  const char *where = "nsdae_sim_set_friction_bound";
  const int kind = NSDAE_NAME_FRICTIONAL_JOINT;
  nsdae_error_clear(&sim->error);
  if (j < 0 || j >= sim->model.dims.f) return bad_index(sim, where, "j", j, sim->model.dims.f);
  if (!(bound >= 0) || isinf(bound))
    return bad_coefficient(sim, where, "bound", kind, j, bound, "at least 0, finite");
  if (!sim->system->frictional_joint[j].bounded)
    return bad_coefficient(sim, where, "bound", kind, j, bound,
                           "set in the system first (nsdae_system_set_friction_bound)");
  int status = check_change(sim);
  if (status < 0) return status;
  jump(sim);
  sim->model.frictional_joint[j].bound = bound;
  sim->now->result.end.have &= ~(unsigned)NSDAE_TERM_BOUND | sim->now->result.end.absent;
  return prepare_method(sim);
}

/* What is wrong with control i and its value, if anything. */
static int check_control(nsdae_sim *sim, const char *where, int i, double value)
{
  const nsdae_maker *maker = &sim->system->maker;
  nsdae_error_clear(&sim->error);
  if (i < 0 || i >= maker->controls) return bad_index(sim, where, "i", i, maker->controls);
  const char *fixed = maker->fixed(maker->of, i);
  if (!fixed && isfinite(value)) return NSDAE_OK;
  if (fixed)
    nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "i", "control i = %d: %s", i, fixed);
  else
    nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "value",
                    "value = %g of control %d is outside its range: it must be finite", value, i);
  return nsdae_error_at(&sim->error, NSDAE_E_ARGUMENT, i, NAN);
}

/* F and the target speeds jump; nothing else at the state depends on controls. The next step takes
 * them from the callbacks, and the certificate F v. */
NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_set_control, (nsdae_sim * sim, int i, double value), sim, i,
               value)
{
  int status = check_control(sim, "nsdae_sim_set_control", i, value);
  if (status < 0 || value == sim->control.value[i]) return status;
  status = check_change(sim);
  if (status < 0) return status;
  jump(sim);
  nsdae_terms *here = &sim->now->result.end;
  sim->control.value[i] = value;
  here->have &= ~(unsigned)(NSDAE_TERM_FORCE | NSDAE_TERM_SLIDE) | here->absent;
  sim->now->work.power = NAN;
  return prepare_method(sim);
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_get_control, (nsdae_sim * sim, int i, double *value), sim, i,
               value)
{
  if (!value) return NSDAE_E_ARGUMENT;
  int status = check_control(sim, "nsdae_sim_get_control", i, 0);
  if (status == NSDAE_OK) *value = sim->control.value[i];
  return status;
}
