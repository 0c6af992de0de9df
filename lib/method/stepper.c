#include "stepper.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "least.h"
#include "vector.h"

void nsdae_stepper_prepare_terms(nsdae_stepper *s, nsdae_terms *terms)
{
  terms->system = s->system;
  terms->differences = &s->differences;
  terms->error = s->error;
  terms->by.list.shares = &s->problem.dispatch.shares;
}

/* Differences are good to about 1e-10, relative: an iteration does not settle below that. */
static double settled(const nsdae_system *system, double tol)
{
  const nsdae_dims *d = &system->dims;
  int differs =
      (d->m > 0 && !(nsdae_system_has_jacobian(system) && system->call.constraint_bias)) ||
      (d->k > 0 && !system->tracked && (!system->call.gap_normal || !system->call.contact_bias));
  return differs ? fmax(tol, 1e-9) : tol;
}

void nsdae_stepper_prepare(nsdae_stepper *s)
{
  const nsdae_sim_options *o = s->options;
  s->iteration_tol = settled(s->system, o->iteration_tol);
  s->differences.system = s->system;
  nsdae_stepper_prepare_terms(s, &s->middle);
  int integrates = o->method == NSDAE_METHOD_EVENT || o->method == NSDAE_METHOD_PENALTY;
  s->kkt.n = integrates ? s->system->dims.nv : 0;
  s->kkt.m = integrates ? s->system->dims.m : 0;
  s->kkt.blocks = &s->system->blocks;
  s->kkt.rank_tol = o->rank_tol;
  /* of event: the larger of its laws and of implicit's, which may step in */
  int edges = o->method == NSDAE_METHOD_EVENT ? nsdae_law_edges_to_start(o->polygon) : o->polygon;
  int gives = o->method == NSDAE_METHOD_IMPLICIT || o->method == NSDAE_METHOD_MOREAU;
  const nsdae_accuracy accuracy = {o->contact_tol, o->contact_work, gives ? o->contact_give : 0};
  nsdae_contacts_set(&s->contacts, s->system, s->error, &accuracy, edges);
  if (edges != o->polygon) nsdae_contacts_laws(&s->contacts, o->polygon);
  nsdae_problem_prepare(&s->problem, &s->contacts, o->rank_tol,
                        o->redundant == NSDAE_REDUNDANT_LEAST_NORM);
}

void nsdae_stepper_layout(nsdae_stepper *s, nsdae_arena *arena)
{
  const nsdae_dims *dims = &s->system->dims;
  const nsdae_blocks *blocks = &s->system->blocks;
  long n = dims->nv;
  nsdae_problem_layout(&s->problem, arena);
  nsdae_differences_layout(&s->differences, arena);
  nsdae_terms_layout(&s->middle, arena);
  nsdae_kkt_layout(&s->kkt, arena);
  s->mean.M = NSDAE_ARENA_DOUBLES(arena, blocks->square[blocks->count]);
  nsdae_arena_doubles(arena, dims->nq, (double **[]){&s->q, &s->qdot[0], &s->qdot[1], NULL});
  nsdae_arena_doubles(arena, n,
                      (double **[]){&s->v, &s->r, &s->mean.F, &s->v_other, &s->size, NULL});
  nsdae_arena_doubles(arena, dims->m, (double **[]){&s->impulse, &s->rate, NULL});
  s->parent = NSDAE_ARENA_INTS(arena, blocks->count + 1L);
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
  memset(s->differences.by_id.wanted, 0, sizeof s->differences.by_id.wanted);
  state->terms->evals = s->middle.evals = result->end.evals = &result->counters.evals;
}

int *nsdae_stepper_lay_basis(const nsdae_stepper *s, nsdae_memory_part *part)
{
  int *basis = nsdae_memory_wholes(part, NSDAE_BY_SLOT((size_t)s->contacts.rows_most));
  nsdae_memory_wholes(part, NSDAE_OF_ALL(3 * (size_t)s->contacts.slides.count));
  return basis;
}

void nsdae_stepper_lay(const nsdae_stepper *s, nsdae_memory_part *part)
{
  nsdae_stepper_lay_basis(s, part);
}

static int is_accepted(const nsdae_stepper *s, double residual, double tol)
{
  return residual <= fmax(tol, nsdae_accuracy_accept(&s->contacts.lcp.accuracy, tol));
}

int nsdae_step_end(const nsdae_step *step)
{
  const nsdae_stepper *s = step->tools;
  nsdae_result *result = step->result;
  const nsdae_solved *solved = s->problem.dispatch.solved;
  for (int i = 0; i < s->system->dims.m; i++) result->multiplier[i] = s->impulse[i] / step->h;
  result->smooth = !nsdae_problem_any(&s->problem);
  if (result->smooth) return NSDAE_OK;
  /* position motors are driven from outside */
  double motors;
  result->work = nsdae_problem_work(&s->problem, &motors);
  result->carried -= motors;
  /* islands are solved by their own scale, a step is judged by that of all */
  result->worst_residual = nsdae_problem_residual(&s->problem);
  result->contact_tol = solved->tol;
  result->above.residual = nsdae_natural_residual_scaled(
      &(nsdae_natural_residual){solved->worst.left, solved->residual.speed, 0});
  result->above.tol = solved->worst.tol;
  result->above.hidden = solved->hidden;
  result->counters.inexact = !(result->above.residual <= result->above.tol);
  if (is_accepted(s, result->worst_residual, result->contact_tol) &&
      is_accepted(s, result->above.residual, result->above.tol))
    return NSDAE_OK;
  nsdae_error_set(s->error, NSDAE_E_LCP, "nsdae_contacts", "contact_tol",
                  "at t = %g the contact problem was solved to %.3g, above %.3g; a smaller dt "
                  "or less friction may help",
                  step->t_end, result->above.residual, result->above.tol);
  return nsdae_error_at(s->error, NSDAE_E_LCP, -1, step->t_end);
}

int nsdae_stepper_factor(nsdae_stepper *s, nsdae_terms *terms, const double *M)
{
  int least_norm = s->options->redundant == NSDAE_REDUNDANT_LEAST_NORM;
  int status = nsdae_terms_factor(terms, M, &s->kkt, least_norm);
  nsdae_count_rank(s->counters, s->kkt.rank, s->kkt.kept, s->kkt.left);
  return status;
}

int nsdae_step_close(const nsdae_step *step, nsdae_terms *terms)
{
  return nsdae_problem_close(&step->tools->problem, terms, &step->result->closed,
                             &step->result->impulses, step->state->closed, step->state->impulses);
}

/* As far as closed contacts may have come apart since the start, twice: the fastest along its
 * directions and, as its normal turns, along any: |W|^T |v|. */
int nsdae_step_update(const nsdae_step *step, nsdae_terms *terms)
{
  const nsdae_impulses *r = &step->result->impulses;
  int count = step->result->closed.count, nt = terms->system->dims.nt;
  if (count == 0) return NSDAE_OK;
  double fastest = fmax(nsdae_largest(count, r->before), nsdae_largest(count * nt, r->before_t));
  for (int a = 0; a < count; a++) {
    const nsdae_terms *start = step->start;
    double along = nsdae_rows_dot_sizes(&start->system->blocks, &start->by.normal, a, terms->v);
    fastest = fmax(fastest, along + fabs(start->w_N[a]));
  }
  return nsdae_problem_update(&step->tools->problem, terms,
                              nsdae_terms_touch(terms) + 2 * step->h * fastest);
}

int nsdae_step_solve(const nsdae_step *step, const nsdae_terms *terms, const double *M,
                     const double *r, int with_contacts, double *v, double *lambda)
{
  nsdae_stepper *s = step->tools;
  nsdae_counters *c = &step->result->counters;
  int status = nsdae_problem_solve(&s->problem, terms, M, r, with_contacts, v, s->size, lambda);
  const nsdae_solved *solved = s->problem.dispatch.solved;
  nsdae_count_rank(c, solved->rank, solved->kept, solved->left);
  c->islands = solved->islands;
  c->island_contacts = solved->contacts;
  if (solved->lcps == 0 && status == NSDAE_OK) return status;
  c->lcps += solved->lcps;
  c->lcp_pivots += solved->pivots;
  if (solved->problem) step->result->problem = solved->problem;
  step->result->single = solved->single;
  if (solved->cones) step->result->cones = solved->cones;
  return status;
}

int nsdae_step_judge_rank(const nsdae_step *step, const nsdae_terms *terms, int *redundant)
{
  nsdae_stepper *s = step->tools;
  const nsdae_dims *d = &s->system->dims;
  nsdae_terms *start = step->start;
  int least_norm = s->options->redundant == NSDAE_REDUNDANT_LEAST_NORM;
  nsdae_island_dispatch_rank(&s->problem.dispatch, s->options->rank_tol, least_norm);
  *redundant = d->m > 0 && s->options->redundant == NSDAE_REDUNDANT_LEAST_NORM;
  if (!*redundant) return NSDAE_OK;
  int status = nsdae_terms_need(start, NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_problem_factor(&s->problem, terms, 0);
  if (status < 0) return status;
  int worst;
  double drift = nsdae_least_drift(start, &worst);
  nsdae_island_dispatch_rank(&s->problem.dispatch, nsdae_least_sine(s->options->rank_tol, drift),
                             1);
  memset(s->r, 0, (size_t)d->nv * sizeof *s->r);
  memset(s->rate, 0, (size_t)d->m * sizeof *s->rate);
  return nsdae_step_solve(step, start, start->M, s->r, 0, s->v_other, s->rate);
}

/* Factors the constraints at the terms' point, in the islands of the start; the rank of all. hold:
 * redundant rows as before. */
static int factor_constraints(const nsdae_step *step, nsdae_terms *terms, int hold, int *rank)
{
  nsdae_stepper *s = step->tools;
  nsdae_counters kept = step->result->counters; /* a look ahead is no part of the step */
  int status = nsdae_terms_need(terms, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_problem_factor(&s->problem, step->start, hold);
  memset(s->r, 0, (size_t)s->system->dims.nv * sizeof *s->r);
  memset(s->rate, 0, (size_t)s->system->dims.m * sizeof *s->rate);
  if (status == NSDAE_OK)
    status = nsdae_step_solve(step, terms, terms->M, s->r, 0, s->v_other, s->rate);
  *rank = s->problem.dispatch.solved->rank;
  kept.evals = step->result->counters.evals;
  step->result->counters = kept;
  return status;
}

int nsdae_step_cross(const nsdae_step *step)
{
  /* Of the larger sine at the ends; no bars that are so far from one line are near a change point.
   */
  const double more = 4, most = 0.5;
  nsdae_stepper *s = step->tools;
  nsdae_island_dispatch *d = &s->problem.dispatch;
  int rank, now, worst, status;
  double sine[3] = {0}; /* at the start, half a step and a step ahead */
  if (s->system->dims.m == 0) return 0;
  status = nsdae_terms_need(step->start, NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN);
  if (status < 0) return status;
  double least = s->options->rank_tol;
  if (s->options->redundant == NSDAE_REDUNDANT_LEAST_NORM)
    least = nsdae_least_sine(least, nsdae_least_drift(step->start, &worst));
  nsdae_island_dispatch_rank(d, least, 1);
  status = factor_constraints(step, step->start, 0, &rank); /* which rows are redundant */
  for (int i = 0; i < 3 && status == NSDAE_OK; i++) {
    nsdae_terms *at = i == 0 ? step->start : step->end;
    nsdae_units_move(s->units, s->system->dims.nq, step->start->q, i * step->h / 2, s->qdot[0],
                     s->q);
    if (i > 0) nsdae_terms_at(at, step->start->t + i * step->h / 2, s->q, step->start->v);
    status = factor_constraints(step, at, 1, &now);
    sine[i] = now < rank ? d->solved->left : d->solved->kept;
  }
  if (status < 0) return status;
  /* a sine is the distance from the pose, on either side: it is passed if the mean of the ends is
   * not what it has half way */
  double sum = sine[0] + sine[2], change = fabs(sine[0] - sine[2]);
  if (fabs(2 * sine[1] - change) < fabs(2 * sine[1] - sum)) change = sum;
  double tol = more * fmax(sine[0], sine[2]);
  double nearest = fmin(sine[0], sine[2]);
  if (nearest <= 16 * change) step->result->crossed.sine = nearest;
  if (!(nearest <= 4 * change) || tol > most) return 0;
  step->result->crossed.sine = 0;
  nsdae_island_dispatch_rank(d, fmax(tol, least), 1);
  status = factor_constraints(step, step->start, 0, &now);
  return status < 0 ? status : now < rank;
}

int nsdae_step_impact(const nsdae_step *step, const nsdae_terms *terms, const double *M,
                      const double *r, const double *lambda, double *v)
{
  nsdae_stepper *s = step->tools;
  nsdae_problem *p = &s->problem;
  double size = nsdae_largest(s->system->dims.nv, r);
  nsdae_circles circles = nsdae_circles_begin(terms, p->joint_own, lambda,
                                              s->contacts.lcp.options.tol, size, p->joint_bound);
  int status;
  circles.friction = p->results->frictional_joint_impulse;
  do {
    for (int i = 0; i < s->system->dims.m; i++) s->impulse[i] = -terms->constraint.phi_t[i];
    status = nsdae_step_solve(step, terms, M, r, 1, v, s->impulse);
    circles.part = fmax(circles.part, p->dispatch.solved->tol);
  } while (nsdae_circles_again(&circles, s->impulse, &status));
  if (status == NSDAE_OK && step->result->closed.count > 0)
    step->result->carried = nsdae_problem_carried(&s->problem, terms);
  return status;
}

int nsdae_stepper_goes_on(const nsdae_stepper *s, const char *method, const char *advice, double t,
                          double t_end)
{
  int most = s->options->inner_steps_max;
  if (s->counters->iterations < most || t >= t_end)
    return nsdae_interrupted(&s->interrupt, s->error, nsdae_system_time(s->system, t));
  nsdae_error_set(s->error, NSDAE_E_CONVERGENCE, method, "inner_steps_max",
                  "the integrator is at t = %g after %d steps towards t = %g: %s",
                  nsdae_system_time(s->system, t), most, nsdae_system_time(s->system, t_end),
                  advice);
  return nsdae_error_at(s->error, NSDAE_E_CONVERGENCE, -1, nsdae_system_time(s->system, t));
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
