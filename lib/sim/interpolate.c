/* What is between the ends of the last step.
 *
 * Time-stepping: v is the straight line from v_0 to v_1, q the parabola through q_0 and q_1 with
 * the difference of dq/dt at both ends,
 *
 *   q(s) = q_0 + s (q_1 - q_0) + h/2 (s^2 - s) (H_1 v_1 - H_0 v_0),   0 <= s <= 1,
 *
 * for implicit, q_1 = q_0 + h/2 (H_0 v_0 + H_1 v_1), the integral of the line.
 *
 * A method that integrates goes from the state before to t, into a point aside. */
#include "errors.h"
#include "sim_impl.h"

#include <string.h>

static int by_parabola(nsdae_sim *sim, const nsdae_terms *from, const nsdae_terms *to, double t,
                       double *q, double *v)
{
  nsdae_stepper *tools = &sim->stepper;
  double h = to->t - from->t, s = (t - from->t) / h;
  int status = nsdae_kinematics_at(from, from->v, tools->qdot[0]);
  if (status == NSDAE_OK) status = nsdae_kinematics_at(to, to->v, tools->qdot[1]);
  if (status < 0) return status;
  for (int i = 0; i < sim->model.dims.nq; i++)
    q[i] = from->q[i] + s * (to->q[i] - from->q[i]) +
           h / 2 * (s * s - s) * (tools->qdot[1][i] - tools->qdot[0][i]);
  for (int i = 0; i < sim->model.dims.nv; i++) v[i] = from->v[i] + s * (to->v[i] - from->v[i]);
  return NSDAE_OK;
}

static void copy(const nsdae_terms *at, double *q, double *v)
{
  memcpy(q, at->q, (size_t)at->system->dims.nq * sizeof *q);
  memcpy(v, at->v, (size_t)at->system->dims.nv * sizeof *v);
}

static int integrate(nsdae_sim *sim, nsdae_result *before, double t, double *q, double *v)
{
  nsdae_result *r = &sim->aside->result;
  const nsdae_state state = {.terms = &before->end, .memory = &before->memory};
  unsigned have = before->end.have;
  nsdae_result_clear(r);
  nsdae_memory_copy(&r->memory, &before->memory);
  nsdae_stepper_count(&sim->stepper, &state, r);
  int status = sim->method->advance(sim->own, &state, t, r);
  before->end.have = have;
  if (status < 0) return status;
  if (r->given_up)
    return by_parabola(sim, &before->end, &nsdae_sim_shown(sim)->result.end, t, q, v);
  copy(&r->end, q, v);
  return NSDAE_OK;
}

static int by_integration(nsdae_sim *sim, nsdae_result *before, double t, double *q, double *v)
{
  int status;
  while ((status = integrate(sim, before, t, q, v)) == NSDAE_ARRAYS_GROW)
    if ((status = nsdae_sim_grow(sim)) < 0) break;
  return status;
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_interpolate, (nsdae_sim * sim, double t, double *q, double *v),
               sim, t, q, v)
{
  const char *where = "nsdae_sim_interpolate";
  nsdae_error_clear(&sim->error);
  if (!q || !v)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, q ? "v" : "q", "%s is NULL",
                           q ? "v" : "q");
  const nsdae_point *shown = nsdae_sim_shown(sim);
  nsdae_point *before = shown == sim->next ? sim->now : sim->next;
  if (!sim->stage.started || (shown == sim->now && !sim->stage.between))
    return nsdae_error_set(
        &sim->error, NSDAE_E_STATE, where, "",
        "there is no last step: no step was taken since the start, or it failed");
  const nsdae_terms *from = &before->result.end, *to = &shown->result.end;
  double first = nsdae_terms_time(from), last = nsdae_terms_time(to);
  if (!(t >= first && t <= last))
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "t",
                           "t = %.17g is outside the last step, from %.17g to %.17g", t, first,
                           last);
  double since = t - sim->model.epoch;
  int at_end = t == last || since >= to->t;
  if (at_end || t == first || since <= from->t) {
    copy(at_end ? to : from, q, v);
    return NSDAE_OK;
  }
  if (!sim->aside || shown->result.counters.fallbacks > 0)
    return by_parabola(sim, from, to, since, q, v);
  return by_integration(sim, &before->result, since, q, v);
}
