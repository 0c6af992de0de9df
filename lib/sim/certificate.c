/* The certificate of a record, by the results of its step; and the work of its step.
 *
 * A time-stepping method does the work of its own quadrature of the forces, of the mass matrix
 * that changes, T = v^T M v / 2, and of moving constraints and contacts:
 *
 *   h/2 (F_0 v_0 + F_1 v_1) + vm^T (M_1 - M_0) vm / 2 + Lambda Phi_t - Lambda_c w,   vm = (v_0 +
 * v_1) / 2
 *
 * penalty and event integrate it with the motion, by the same terms in continuous time. Where
 * backward differences do not control that integral, its error is unknown and the change of energy
 * counts as work. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "errors.h"
#include "sim_impl.h"
#include "vector.h"

/* vm^T (M_1 - M_0) vm / 2 */
static double inertia(const nsdae_terms *from, const nsdae_terms *to)
{
  const nsdae_blocks *blocks = &to->system->blocks;
  size_t bytes = blocks->square[blocks->count] * sizeof *to->M;
  if (memcmp(to->M, from->M, bytes) == 0) return 0; /* as often */
  return nsdae_blocks_change(blocks, to->M, from->M, from->v, to->v) / 8;
}

/* F v, and what forces do on the rounding of the coordinates, which each step has anew: less energy
 * than that is not resolved. */
static double power_of(const nsdae_terms *T, double *rounding)
{
  const nsdae_dims *d = &T->system->dims;
  const double *F = T->F, *v = T->v;
  double power = 0, sum = 0;
  for (int j = 0, n = d->nv; j < n; j++) {
    power += F[j] * v[j];
    sum += fabs(F[j]);
  }
  *rounding = DBL_EPSILON * (1 + nsdae_largest(d->nq, T->q)) * sum;
  return power;
}

/* Work of moving constraints and contacts in a step that did `of`, by the velocities w and Phi_t at
 * T, one of its ends: half of each. Lists know theirs. */
static inline double half_driven(const nsdae_terms *T, const nsdae_result *of, double h)
{
  const nsdae_dims *d = &T->system->dims;
  const nsdae_impulses *p = &of->impulses;
  double sum = h * nsdae_dot(d->m, of->multiplier, T->constraint.phi_t);
  if (!of->smooth)
    sum -= nsdae_dot(d->k, p->normal, T->w_N) + nsdae_dot(d->k * d->nt, p->tangential, T->w_T) +
           nsdae_dot(d->f, p->frictional_joint_impulse, T->frictional_joint.w) + of->carried;
  return sum / 2;
}

/* sum |W_j| / sqrt(M_jj) along the normal of contact i: (W^T M^-1 W)^(1/2) at most, of a diagonal
 * M. */
static double root_of_inertia(const nsdae_terms *T, const nsdae_rows *normal, int i)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  double sum = 0;
  for (int p = normal->first[i]; p < normal->first[i + 1]; p++) {
    int b = normal->block[p];
    size_t n = (size_t)nsdae_blocks_size(blocks, b);
    const double *M = T->M + blocks->square[b], *W = normal->value + normal->at[p];
    for (size_t j = 0; j < n; j++) sum += fabs(W[j * normal->stride]) / sqrt(M[j * (n + 1)]);
  }
  return sum;
}

/* What contact impulses L do on velocities that are rounded as those that they give are: a column
 * at rest gains and loses that in every step. L_i turns its contact's velocity by G_ii L_i, with
 * the Delassus matrix G, and that of j by sqrt(G_ii G_jj) L_i at most. A method that steps in time
 * closes its contacts once in a step: those of the problem are those of the impulses. */
static double rounding_of_contacts(const nsdae_problem *p, const nsdae_point *point)
{
  double sum = 0;
  for (int a = 0; a < p->count; a++) {
    int i = p->number[a];
    sum += fabs(point->result.impulses.normal[i]) *
           root_of_inertia(&point->result.end, &p->home->by.normal, i);
  }
  return 4 * DBL_EPSILON * sum * sum;
}

/* Energy that impulses within contact_tol may give. With x = d L, y = u + mu |u_T| e_N and the
 * natural map f = x - P_K(x - y) the projection is x - f in K, (x - f) (y - f) = 0, and
 *
 *   L y = (L - f / d) f + y f / d <= |f| (|L| + |y| / d),
 *
 * where |f| <= sqrt(3) rho by entries. One of x and y is f alone: of a contact that presses |y| / d
 * is the smaller one. */
static double tolerance_of_contacts(const nsdae_problem *p, const nsdae_point *point)
{
  double sum = 0, residual = p->dispatch.solved->residual.left;
  for (int a = 0; a < p->count; a++)
    sum += (1 + p->law[p->number[a]].mu) * fabs(point->result.impulses.normal[p->number[a]]);
  return 2 * sqrt(3) * residual * sum;
}

/* A contact that had an impulse in the step before left it with v_N = 0. If v_N < 0 is found now,
 * its normal has turned, by the angle h v kappa on a surface of curvature kappa, and the impulse
 * takes (h v kappa)^2 / 2 of the energy, which no dissipation explains: of first order in h in all.
 */
static double taken_in_turns(const nsdae_problem *p, const nsdae_result *r)
{
  const nsdae_impulses *of = &r->impulses;
  double sum = 0;
  for (int a = 0; a < p->count; a++) {
    int i = p->number[a];
    if (!r->closed.fresh[i] && of->normal[i] > 0 && of->before[i] < 0)
      sum -= of->normal[i] * (of->before[i] + of->after[i]) / 2;
  }
  return sum;
}

/* By the method's quadrature. The terms at the end are those that the next step begins with. */
static int work_of_step(const nsdae_problem *p, int integrates, nsdae_point *before,
                        nsdae_point *point)
{
  nsdae_terms *from = &before->result.end, *to = &point->result.end;
  nsdae_work *w = &point->work;
  const nsdae_result *r = &point->result;
  unsigned at_contacts = r->smooth ? 0u : NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE;
  unsigned terms = NSDAE_TERM_FORCE | NSDAE_TERM_PHI_T | at_contacts;
  double rounding, h = to->t - from->t, start = before->work.power;
  int status = nsdae_terms_need(from, terms);
  if (status == NSDAE_OK) status = nsdae_terms_need(to, terms);
  if (status < 0) return status;
  int anew = isnan(start);                                   /* a control was set: F jumped */
  if (integrates || anew) start = power_of(from, &rounding); /* nobody needed it */
  *w = before->work;
  w->power = power_of(to, &rounding);
  w->forces = h / 2 * (start + w->power);
  w->inertia = inertia(from, to) - r->lifted;
  w->driven = 0;
  if (to->system->dims.m > 0 || !r->smooth)
    w->driven = half_driven(from, r, h) + half_driven(to, r, h);
  w->sum += w->forces + w->inertia + w->driven;
  w->turnover += fabs(w->forces);
  w->carried += fabs(w->driven);
  if (!anew) w->unsure += h / 4 * fabs(w->power - 2 * start + w->earlier);
  w->earlier = start;
  w->rounding += rounding;
  /* what the contacts of the step did: more than rounding of their impulses, they gave */
  w->spent += fabs(r->work - r->raised);
  w->turned += nsdae_larger(0, taken_in_turns(p, r));
  double given = r->work - r->raised;
  if (given > 0)
    w->gained +=
        nsdae_larger(0, given - rounding_of_contacts(p, point) - tolerance_of_contacts(p, point));
  return NSDAE_OK;
}

static inline void worst(double value, int item, double *most, int *of)
{
  if (!(value > *most)) return;
  *most = value;
  *of = item;
}

static void measure_impulses(nsdae_certificate *c, const nsdae_result *r,
                             const nsdae_coefficients *law, int count)
{
  const nsdae_impulses *p = &r->impulses;
  int nt = r->end.system->dims.nt;
  for (int i = 0; i < count; i++) {
    const double *tangential = p->tangential + (size_t)i * (size_t)nt;
    double normal = p->normal[i];
    double along = nt == 1 ? fabs(tangential[0]) : nsdae_norm(nt, tangential);
    if (normal == 0 && along == 0) continue;
    worst(-normal, i, &c->pull, &c->pull_contact);
    worst(along - law[i].mu * normal, i, &c->cone_excess, &c->cone_contact);
    if (!r->located)
      worst(fabs(normal * (p->after[i] + law[i].e_n * p->before[i])), i, &c->complementarity,
            &c->complementarity_contact);
  }
}

/* Of time stepping: |Lambda_S| less the bound of its impulse, b h + mu h |lambda|. */
static void measure_joints(nsdae_certificate *c, const nsdae_problem *problem,
                           const nsdae_result *r, double h)
{
  const nsdae_system *s = r->end.system;
  for (int j = 0; j < s->dims.f; j++) {
    const nsdae_frictional_joint *joint = &s->frictional_joint[j];
    double load = joint->mu > 0 ? joint->mu * h * fabs(r->multiplier[joint->constraint]) : 0,
           impulse = fabs(r->impulses.frictional_joint_impulse[j]);
    worst(impulse - problem->joint_bound[j] - load, -1, &c->cone_excess, &c->cone_contact);
  }
}

/* Of event: what is closed at the end of the step and has pressed in it keeps its place. */
static int measure_closed(nsdae_certificate *c, nsdae_result *r)
{
  int k = r->end.system->dims.k, status = NSDAE_OK;
  if (nsdae_largest(k, r->impulses.normal) > 0)
    status = nsdae_terms_need(&r->end, NSDAE_TERM_NORMAL | NSDAE_TERM_BIAS);
  for (int i = 0; i < k && status == NSDAE_OK; i++)
    if (r->impulses.mode[i] != NSDAE_MODE_OPEN && r->impulses.normal[i] != 0)
      worst(fabs(r->impulses.normal[i] * nsdae_terms_normal_rate(&r->end, i, r->end.v)), i,
            &c->complementarity, &c->complementarity_contact);
  return status;
}

static int measure_rates(nsdae_certificate *c, nsdae_result *r)
{
  const unsigned terms = NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T;
  int there = (~r->end.have & terms) == 0;
  if (r->end.system->dims.m == 0) return NSDAE_OK;
  if (!there && !r->rate.known) {
    int status = nsdae_terms_need(&r->end, terms);
    if (status < 0) return status;
    there = 1;
  }
  if (there && !r->rate.known) nsdae_result_rate(r, &r->end, r->end.v);
  c->constraint_rate = r->rate.most;
  c->rate_constraint = r->rate.constraint;
  return NSDAE_OK;
}

static inline int measure_certificate(const nsdae_sim *sim, nsdae_point *point, double h)
{
  static const nsdae_certificate none = {.pull_contact = -1,
                                         .cone_contact = -1,
                                         .penetration_contact = -1,
                                         .drift_constraint = -1,
                                         .rate_constraint = -1,
                                         .complementarity_contact = -1};
  nsdae_result *r = &point->result;
  nsdae_record *record = &point->record;
  nsdae_certificate *c = &record->certificate;
  const nsdae_system *s = r->end.system;
  int status = NSDAE_OK, count = r->closed.count + s->dims.k;
  const double *gap = s->tracked ? r->end.gap : r->closed.gap;
  *c = none;
  /* ---- places */
  for (int i = 0; i < count; i++) worst(-gap[i], i, &c->penetration, &c->penetration_contact);
  worst(r->entered.depth, -1, &c->penetration, &c->penetration_contact);
  for (int i = 0; i < s->dims.m; i++)
    worst(fabs(r->end.constraint.phi[i]), i, &c->constraint_drift, &c->drift_constraint);
  /* ---- energy */
  c->energy = record->kinetic + record->potential;
  c->work = point->work.sum + (record->potential - point->work.potential);
  c->dissipated = record->dissipated;
  c->unexplained =
      record->kinetic - point->accounts.watch.kinetic + record->dissipated - point->work.sum;
  /* ---- impulses and rates */
  if (r->located || !r->smooth) measure_impulses(c, r, sim->stepper.problem.law, count);
  if (!r->located && !r->smooth) measure_joints(c, &sim->stepper.problem, r, h);
  if (r->located && sim->options.method == NSDAE_METHOD_EVENT) status = measure_closed(c, r);
  if (status == NSDAE_OK) status = measure_rates(c, r);
  record->constraint_drift = c->constraint_drift;
  record->penetration = c->penetration;
  return status;
}

int nsdae_certificate_start(const nsdae_sim *sim, nsdae_point *point)
{
  nsdae_certificate *c = &point->record.certificate;
  nsdae_work *w = &point->work;
  double rounding;
  *w = (nsdae_work){.potential = point->record.potential};
  w->power = w->earlier = power_of(&point->result.end, &rounding);
  int status = measure_certificate(sim, point, 0);
  if (sim->system->dims.k == 0) c->penetration_contact = -1; /* the record has no list yet */
  point->accounts.stats.certificate = *c;
  return status;
}

int nsdae_certificate_follow(const nsdae_sim *sim, nsdae_point *before, nsdae_point *point)
{
  const nsdae_result *r = &point->result;
  nsdae_work *w = &point->work;
  int status = NSDAE_OK;
  if (r->located) { /* by the integrator */
    double gain = isfinite(r->gain) ? r->gain : point->record.kinetic - before->record.kinetic;
    *w = before->work;
    w->forces = w->inertia = w->driven = w->power = 0;
    w->sum += gain - r->work;
    /* a joint at rest has velocities up to atol */
    for (int j = 0; j < sim->system->dims.f; j++)
      w->rounding += sim->options.atol * fabs(r->impulses.frictional_joint_impulse[j]);
    w->gained = nsdae_larger(w->gained, -point->record.dissipated);
  } else {
    status = work_of_step(&sim->stepper.problem, sim->aside != NULL, before, point);
  }
  if (status == NSDAE_OK) status = measure_certificate(sim, point, r->end.t - before->result.end.t);
  /* most := the larger of each figure, the energies of the other */
  const nsdae_certificate *c = &point->record.certificate;
  nsdae_certificate *most = &point->accounts.stats.certificate;
  most->energy = c->energy;
  most->work = c->work;
  most->dissipated = c->dissipated;
  most->unexplained = c->unexplained;
  if (c->cone_excess == 0 && c->penetration == 0 &&
      (c->pull_contact & c->cone_contact & c->drift_constraint & c->rate_constraint &
       c->complementarity_contact) == -1)
    return status; /* all are 0 */
  worst(c->pull, c->pull_contact, &most->pull, &most->pull_contact);
  worst(c->cone_excess, c->cone_contact, &most->cone_excess, &most->cone_contact);
  worst(c->penetration, c->penetration_contact, &most->penetration, &most->penetration_contact);
  worst(c->constraint_drift, c->drift_constraint, &most->constraint_drift, &most->drift_constraint);
  worst(c->constraint_rate, c->rate_constraint, &most->constraint_rate, &most->rate_constraint);
  worst(c->complementarity, c->complementarity_contact, &most->complementarity,
        &most->complementarity_contact);
  return status;
}

/* Tolerances of the integrator: in a step, and at an instant, at which what has strayed by 10 times
 * 10 rtol is projected, of T twice that; and of T' by differences. */
static const double energy_steps = 100, energy_events = 200, energy_inertia = 1e-5;

/* sum |M_ij| u_i u_j,  u_i = |v_i| + atol / rtol: a velocity is as good as rtol u_i; slower than
 * impact_velocity it may be none. */
static double energy_size(const nsdae_sim *sim, const nsdae_terms *T)
{
  const nsdae_sim_options *o = &sim->options;
  const nsdae_blocks *blocks = &T->system->blocks;
  double least = fmax(o->atol, o->impact_velocity) / o->rtol, sum = 0;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b);
    const double *M = T->M + blocks->square[b], *v = T->v + blocks->first[b];
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++, M++)
        sum += fabs(*M) * (fabs(v[i]) + least) * (fabs(v[j]) + least);
  }
  return sum;
}

/* sum |F_i| h u_i: the impulse of constraints and closed contacts in a time h is M dv - F h. It
 * does work on an error of v. */
static double reaction_size(const nsdae_sim *sim, const nsdae_terms *T, double h)
{
  double least = fmax(sim->options.atol, sim->options.impact_velocity) / sim->options.rtol, sum = 0;
  for (int i = 0; i < T->system->dims.nv; i++) sum += fabs(T->F[i]) * h * (fabs(T->v[i]) + least);
  return sum;
}

int nsdae_certificate_energy(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point)
{
  nsdae_result *r = &point->result;
  if (!r->located || sim->options.method != NSDAE_METHOD_EVENT) return NSDAE_OK;
  double off = point->record.kinetic - before->record.kinetic - r->gain;
  /* 2 T <= sum |M_ij| max |v|^2: far less than is explained */
  if (fabs(off) <= 2 * energy_inertia * point->record.kinetic) return NSDAE_OK;
  /* what rtol explains of a difference between T and what the equations of motion gave to it */
  double size =
      fmax(energy_size(sim, &r->end), energy_size(sim, &before->result.end)) + r->turnover;
  double tolerances = energy_steps * (double)(r->counters.iterations + 1) +
                      energy_events * (double)r->counters.events;
  double bound = sim->options.rtol * tolerances * size + energy_inertia * (size + r->turnover);
  if (!(fabs(off) > bound)) return NSDAE_OK;
  int status = nsdae_terms_need(&r->end, NSDAE_TERM_FORCE);
  if (status < 0) return status;
  bound +=
      sim->options.rtol * tolerances * reaction_size(sim, &r->end, r->end.t - before->result.end.t);
  if (!(fabs(off) > bound)) return NSDAE_OK;
  nsdae_error_set(r->end.error, NSDAE_E_CONVERGENCE, "nsdae_sim", "rtol",
                  "the kinetic energy changed by %.3g without work up to t = %g, above the "
                  "bound for rtol = %g (%.3g): make rtol smaller, or use method = implicit",
                  off, nsdae_terms_time(&r->end), sim->options.rtol, bound);
  return nsdae_error_at(r->end.error, NSDAE_E_CONVERGENCE, -1, nsdae_terms_time(&r->end));
}
