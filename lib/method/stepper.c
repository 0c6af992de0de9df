#include "stepper.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "vector.h"

void nsdae_stepper_prepare_terms(nsdae_stepper *s, nsdae_terms *terms)
{
  terms->system = s->system;
  terms->differences = &s->differences;
  terms->error = s->error;
}

/* Differences are good to about 1e-10, relative: an iteration does not settle below that. */
static double settled(const nsdae_system *system, double tol)
{
  const nsdae_dims *d = &system->dims;
  int differs =
      (d->m > 0 && !(nsdae_system_has_jacobian(system) && system->call.constraint_bias)) ||
      (d->k > 0 && (!system->call.gap_normal || !system->call.contact_bias));
  return differs ? fmax(tol, 1e-9) : tol;
}

void nsdae_stepper_prepare(nsdae_stepper *s)
{
  const nsdae_sim_options *o = s->options;
  s->iteration_tol = settled(s->system, o->iteration_tol);
  s->differences.system = s->system;
  nsdae_stepper_prepare_terms(s, &s->middle);
  s->kkt.n = s->world ? 0 : s->system->dims.nv;
  s->kkt.m = s->world ? 0 : s->system->dims.m;
  s->kkt.blocks = &s->system->blocks;
  s->kkt.rank_tol = o->rank_tol;
  /* of event: the larger of its laws and of implicit's, which may step in */
  int edges = o->method == NSDAE_METHOD_EVENT ? nsdae_law_edges_to_start(o->polygon) : o->polygon;
  nsdae_contacts_set(&s->contacts, s->system, s->error, o->contact_tol, edges);
  if (edges != o->polygon) nsdae_contacts_laws(&s->contacts, o->polygon);
  if (s->world)
    nsdae_world_prepare(s->world, &s->contacts.lcp.options, o->rank_tol,
                        o->redundant == NSDAE_REDUNDANT_LEAST_NORM);
}

void nsdae_stepper_layout(nsdae_stepper *s, nsdae_arena *arena)
{
  const nsdae_dims *dims = &s->system->dims;
  const nsdae_blocks *blocks = &s->system->blocks;
  long n = dims->nv;
  if (s->world) nsdae_world_layout(s->world, arena);
  nsdae_differences_layout(&s->differences, arena);
  nsdae_terms_layout(&s->middle, arena);
  nsdae_kkt_layout(&s->kkt, arena);
  nsdae_contacts_layout(&s->contacts, dims, arena);
  s->mean.M = NSDAE_ARENA_DOUBLES(arena, blocks->square[blocks->count]);
  s->q = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  s->v = NSDAE_ARENA_DOUBLES(arena, n);
  s->r = NSDAE_ARENA_DOUBLES(arena, n);
  s->mean.F = NSDAE_ARENA_DOUBLES(arena, n);
  s->v_other = NSDAE_ARENA_DOUBLES(arena, n);
  s->size = NSDAE_ARENA_DOUBLES(arena, n);
  s->qdot[0] = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  s->qdot[1] = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  s->impulse = NSDAE_ARENA_DOUBLES(arena, dims->m);
  s->rate = NSDAE_ARENA_DOUBLES(arena, dims->m);
}

int nsdae_stepper_start(nsdae_stepper *s, nsdae_newton_kkt *newton, const nsdae_terms *at)
{
  nsdae_counters counted = *s->counters;
  nsdae_terms_at(&s->middle, at->t, at->q, at->v);
  int status = nsdae_newton_kkt_start(newton, &s->middle);
  *s->counters = counted;
  return status;
}

void nsdae_stepper_count(nsdae_stepper *s, const nsdae_state *state, nsdae_result *result)
{
  s->counters = &result->counters;
  state->terms->evals = s->middle.evals = result->end.evals = &result->counters.evals;
}

void nsdae_stepper_sizes(const nsdae_stepper *s, size_t *reals, size_t *wholes)
{
  *reals = nsdae_contacts_warm_size(&s->contacts);
  *wholes = nsdae_contacts_memory_size(&s->contacts);
}

void nsdae_step_end(const nsdae_step *step)
{
  const nsdae_stepper *s = step->tools;
  nsdae_result *result = step->result;
  for (int i = 0; i < s->system->dims.m; i++) result->multiplier[i] = s->impulse[i] / step->h;
  result->smooth = !nsdae_step_any(step);
  result->work = s->world ? nsdae_world_work(s->world) : nsdae_contacts_work(&s->contacts);
  result->worst_residual =
      s->world ? nsdae_misfit_residual(&s->world->solved.misfit) : s->contacts.lcp.info.residual;
}

int nsdae_stepper_factor(nsdae_stepper *s, nsdae_terms *terms, const double *M)
{
  int least_norm = s->options->redundant == NSDAE_REDUNDANT_LEAST_NORM;
  int status = nsdae_terms_factor(terms, M, &s->kkt, least_norm);
  nsdae_count_rank(s->counters, s->kkt.rank, s->kkt.kept, s->kkt.left);
  return status;
}

int nsdae_stepper_impact(nsdae_stepper *s, nsdae_result *result, const nsdae_terms *terms,
                         const double *r, double *v)
{
  int n = s->system->dims.nv, m = s->system->dims.m;
  memcpy(v, r, (size_t)n * sizeof *v);
  for (int i = 0; i < m; i++) s->impulse[i] = -terms->constraint.phi_t[i];
  int status = nsdae_terms_solve(terms, &s->kkt, 1, v, s->impulse);
  if (status < 0 || !nsdae_contacts_any(&s->contacts)) return status;
  result->problem = &s->contacts;
  memcpy(s->size, r, (size_t)n * sizeof *s->size);
  nsdae_kkt_solve_mass(&s->kkt, s->size);
  status = nsdae_contacts_solve(&s->contacts, terms, &s->kkt, s->size, v, s->impulse);
  result->counters.lcps++;
  result->counters.lcp_pivots += s->contacts.lcp.info.pivots;
  return status;
}

int nsdae_stepper_goes_on(const nsdae_stepper *s, const char *method, const char *advice, double t,
                          double t_end)
{
  int most = s->options->inner_steps_max;
  if (s->counters->iterations < most || t >= t_end)
    return nsdae_interrupted(&s->interrupt, s->error, nsdae_system_time(s->system, t));
  nsdae_error_set(s->error, NSDAE_E_CONVERGENCE, method, "inner_steps_max",
                  "the integrator is at t = %.17g after %d steps towards t = %.17g: %s",
                  nsdae_system_time(s->system, t), most, nsdae_system_time(s->system, t_end),
                  advice);
  s->error->time = nsdae_system_time(s->system, t);
  return NSDAE_E_CONVERGENCE;
}

void nsdae_stepper_momentum(const nsdae_blocks *blocks, const double *M, const double *v, double h,
                            const double *F, double *r)
{
  int n = blocks->first[blocks->count];
  for (int i = 0; i < n; i++) r[i] = h * F[i];
  nsdae_blocks_add_product(blocks, M, v, r);
}

int nsdae_stepper_made(const nsdae_stepper *s, int status, const char *method)
{
  if (status == NSDAE_OK) return status;
  if (status == NSDAE_E_MEMORY)
    return nsdae_error_set(s->error, status, "nsdae_sim_create", "", "out of memory");
  if (s->options->integrator == NSDAE_INTEGRATOR_IDA)
    return nsdae_error_set(s->error, status, "nsdae_sim_create", "integrator",
                           "integrator = ida needs SUNDIALS, and this library was built without it "
                           "(NSDAE_SUNDIALS=OFF): set integrator = auto");
  return nsdae_error_set(s->error, status, "nsdae_sim_create", "method",
                         "method %s needs SUNDIALS, and this library was built without it "
                         "(NSDAE_SUNDIALS=OFF)",
                         method);
}
