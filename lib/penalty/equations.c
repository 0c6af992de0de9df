#include "equations.h"

#include <math.h>
#include <string.h>

#include "stalled_steps.h"
#include "vector.h"

/* ---- penalty law */

static double damping(int kind, double e)
{
  switch (kind) {
  case NSDAE_PENALTY_HUNT_CROSSLEY:
    return 1.5 * (1 - e);
  case NSDAE_PENALTY_LANKARANI_NIKRAVESH:
    return 0.75 * (1 - e * e);
  case NSDAE_PENALTY_FLORES:
    return 1.6 * (1 - e) / e;
  default:
    return 0;
  }
}

/* zeta of the half oscillation that leaves with e times the velocity it came with; 1 for e = 0. */
static double damping_ratio(double e)
{
  const double pi = 3.14159265358979324;
  if (e <= 0) return 1;
  return -log(e) / sqrt(pi * pi + log(e) * log(e));
}

/* Normal force for overlap d (0 where d <= 0), its rate, d'_0 > 0, restitution e, effective mass.
 */
static double penalty_normal(const nsdae_penalty_force *law, double d, double rate,
                             double start_rate, double e, double mass)
{
  double force;
  if (!(d > 0)) return 0;
  if (law->kind == NSDAE_PENALTY_KELVIN_VOIGT)
    force = law->stiffness * d + 2 * damping_ratio(e) * sqrt(law->stiffness * mass) * rate;
  else
    force =
        law->stiffness * pow(d, law->exponent) * (1 + damping(law->kind, e) * rate / start_rate);
  return fmax(force, 0);
}

void nsdae_penalty_slopes(const nsdae_penalty_force *law, double d, double rate, double start_rate,
                          double e, double mass, double *slope)
{
  double K = law->stiffness, n = law->exponent, c = damping(law->kind, e) / start_rate;
  int any = penalty_normal(law, d, rate, start_rate, e, mass) > 0;
  slope[0] = slope[1] = 0;
  if (any && law->kind == NSDAE_PENALTY_KELVIN_VOIGT) {
    slope[0] = K;
    slope[1] = 2 * damping_ratio(e) * sqrt(K * mass);
  } else if (any) {
    slope[0] = n * K * pow(d, n - 1) * (1 + c * rate);
    slope[1] = K * pow(d, n) * c;
  }
}

/* The work of the way in less that of the way out, times c^2; it falls with e'. */
static double work_left(double c, double e)
{
  return c * (1 + e) + log1p(-c * e) - log1p(c);
}

/* By halving. c below 1e-5 leaves rounding of the difference; the series is then as good. */
static double separable(double c)
{
  double low = 0, high = c > 1 ? 1 / c : 1;
  if (c < 1e-5) return 1 - 2 * c / 3;
  for (int i = 0; i < 60; i++) {
    double middle = (low + high) / 2;
    if (work_left(c, middle) > 0)
      low = middle;
    else
      high = middle;
  }
  return low;
}

double nsdae_penalty_restitution(const nsdae_penalty_force *law, double e)
{
  if (law->kind != NSDAE_PENALTY_KELVIN_VOIGT) return separable(damping(law->kind, e));
  double zeta = damping_ratio(e);
  return zeta < 1 ? exp(-2 * zeta * acos(zeta) / sqrt(1 - zeta * zeta)) : exp(-2);
}

/* F_T / v_T: friction of a normal force at the slip speed. */
static double penalty_friction(double mu, double normal, double speed, double regularisation)
{
  return -mu * normal / sqrt(speed * speed + regularisation * regularisation);
}

enum {
  CONTACT_TERMS = NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS,
  RATE_TERMS = CONTACT_TERMS | NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI |
               NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA | NSDAE_TERM_SLIDE |
               NSDAE_TERM_BOUND
};

/* Friction on the frictional joints feeds their normal force: rounds of substitution. */
enum { SLIDE_ROUNDS = 50 };

static void contact_forces(nsdae_penalty_equations *p, const nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  const nsdae_penalty_forces *at = &p->at;
  double regular = p->stepper->options->friction_velocity;
  int nt = s->dims.nt;
  for (int i = 0; i < s->dims.k; i++) {
    const nsdae_coefficients *c = &s->contact[i];
    double speed = 0;
    at->v_n[i] = nsdae_terms_normal_rate(T, i, T->v);
    at->normal[i] = p->base.closed[i]
                        ? penalty_normal(&p->law, -T->gap[i], -at->v_n[i], p->base.start_rate[i],
                                         c->e_n, p->base.mass[i])
                        : 0;
    for (int j = i * nt; j < (i + 1) * nt; j++) {
      at->v_t[j] = nsdae_terms_tangent_rate(T, j, T->v);
      speed = hypot(speed, at->v_t[j]);
    }
    double per_speed = penalty_friction(c->mu, at->normal[i], speed, regular);
    for (int j = i * nt; j < (i + 1) * nt; j++) at->tangential[j] = per_speed * at->v_t[j];
  }
}

/* Multiplier i with the friction on the frictional joints. */
static double multiplier(const nsdae_penalty_equations *p, int i)
{
  const nsdae_penalty_forces *at = &p->at;
  const nsdae_dims *d = &p->stepper->system->dims;
  double sum = at->lambda[i];
  for (int l = 0; l < d->f; l++)
    sum += at->D[(size_t)l * (size_t)d->m + (size_t)i] * at->frictional_joint[l];
  return sum;
}

/* One round of substitution for the friction on the frictional joints; how far it moved. */
static double relax_slides(nsdae_penalty_equations *p, const nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  const nsdae_penalty_forces *at = &p->at;
  double moved = 0, regular = p->stepper->options->friction_velocity;
  for (int j = 0; j < s->dims.f; j++) {
    const nsdae_frictional_joint *joint = &s->frictional_joint[j];
    double v = nsdae_terms_slide_rate(T, j, T->v), limit = T->frictional_joint.bound[j], on[3];
    if (joint->mu > 0) limit += joint->mu * fabs(multiplier(p, joint->constraint));
    for (int i = 0; i < joint->rows; i++) on[i] = multiplier(p, joint->first + i);
    if (joint->rows > 0) limit += joint->radius * nsdae_norm(joint->rows, on);
    double force = v * penalty_friction(1, limit, v, regular);
    moved = fmax(moved, fabs(force - at->frictional_joint[j]) / (1 + fabs(force)));
    at->v_s[j] = v;
    at->frictional_joint[j] = force;
  }
  return moved;
}

/* Friction on the frictional joints, with U and D of their directions; a and lambda are free of it
 * before. */
static int slide_forces(nsdae_penalty_equations *p, const nsdae_terms *T, double *a)
{
  const nsdae_penalty_forces *at = &p->at;
  int n = T->system->dims.nv, m = T->system->dims.m, f = T->system->dims.f;
  double moved = 1;
  memset(at->U, 0, (size_t)n * (size_t)f * sizeof *at->U);
  for (int j = 0; j < f; j++)
    nsdae_rows_add(&T->system->blocks, &T->by.frictional_joint, j, 1,
                   at->U + (size_t)j * (size_t)n);
  memset(at->D, 0, (size_t)m * (size_t)f * sizeof *at->D);
  int status = nsdae_terms_solve(T, &p->stepper->kkt, f, at->U, at->D);
  if (status < 0) return nsdae_progress_code(status, p->stepper->error);
  memset(at->frictional_joint, 0, (size_t)f * sizeof *at->frictional_joint);
  for (int round = 0; moved > 1e-14 && round < SLIDE_ROUNDS; round++) moved = relax_slides(p, T);
  nsdae_add_product(n, f, at->U, at->frictional_joint, a);
  nsdae_add_product(m, f, at->D, at->frictional_joint, at->lambda);
  return moved > 1e-8 ? 1 : 0; /* no convergence: a smaller step */
}

void nsdae_penalty_add_forces(const nsdae_terms *T, const nsdae_rows *rows, int each, double scale,
                              const double *force, double *r)
{
  for (int n = 0; n < T->system->dims.k; n++)
    for (int i = nsdae_system_contact(T->system, n), j = i * each; j < (i + 1) * each; j++)
      if (force[j] != 0) nsdae_rows_add(&T->system->blocks, rows, j, scale * force[j], r);
}

/* a [nv] and lambda of the forces at the terms' point. */
static int accelerations(nsdae_penalty_equations *p, nsdae_terms *T, double *a)
{
  nsdae_stepper *s = p->stepper;
  const nsdae_dims *d = &s->system->dims;
  const nsdae_penalty_forces *at = &p->at;
  double alpha = s->options->baumgarte_alpha, beta = s->options->baumgarte_beta;
  contact_forces(p, T);
  memcpy(a, T->F, (size_t)d->nv * sizeof *a);
  nsdae_penalty_add_forces(T, &T->by.normal, 1, 1, at->normal, a);
  nsdae_penalty_add_forces(T, &T->by.tangent, d->nt, 1, at->tangential, a);
  for (int i = 0; i < d->m; i++) {
    double rate = nsdae_terms_constraint_rate(T, i, T->v);
    at->lambda[i] = -T->constraint.omega[i] - 2 * alpha * rate - beta * beta * T->constraint.phi[i];
  }
  int status = nsdae_terms_solve(T, &s->kkt, 1, a, at->lambda);
  if (status < 0) return nsdae_progress_code(status, s->error);
  return d->f > 0 ? slide_forces(p, T, a) : 0;
}

/* rate := E', A' and the linear forces, of the forces in `at` at the terms' point, q' = qdot. */
static int powers(nsdae_penalty_equations *p, const nsdae_terms *T, const double *qdot,
                  double *rate)
{
  const nsdae_dims *d = &T->system->dims;
  const nsdae_penalty_forces *at = &p->at;
  int kt = d->k * d->nt, status = nsdae_power_inertia(&p->power, T, qdot, &rate[1]);
  rate[0] = -nsdae_dot(d->k, at->normal, at->v_n) - nsdae_dot(kt, at->tangential, at->v_t) -
            nsdae_dot(d->f, at->frictional_joint, at->v_s);
  rate[1] += nsdae_dot(d->nv, T->F, T->v) + nsdae_dot(d->m, at->lambda, T->constraint.phi_t) -
             nsdae_dot(d->k, at->normal, T->w_N) - nsdae_dot(kt, at->tangential, T->w_T) -
             nsdae_dot(d->f, at->frictional_joint, T->frictional_joint.w);
  double *linear = rate + nsdae_penalty_at(d).linear - nsdae_penalty_at(d).work;
  memset(linear, 0, 3 * (size_t)d->k * sizeof *linear);
  nsdae_terms_add_all_linear(T, at->normal, at->tangential, linear);
  return status;
}

/* Bytes of all forces, which are in the order of z. */
static size_t forces_size(const nsdae_dims *d)
{
  return (size_t)(nsdae_penalty_at(d).work - nsdae_penalty_at(d).lambda) * sizeof(double);
}

void nsdae_penalty_take(nsdae_penalty_equations *p, const double *y)
{
  const nsdae_dims *d = &p->stepper->system->dims;
  const nsdae_penalty_forces *at = &p->at;
  memcpy(at->lambda, y + nsdae_penalty_at(d).lambda, forces_size(d));
}

int nsdae_penalty_rate(double t, const double *z, double *zdot, int whole, void *user)
{
  nsdae_penalty_equations *p = user;
  nsdae_stepper *s = p->stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = &s->system->dims;
  const nsdae_penalty_forces *at = &p->at;
  nsdae_terms_at(T, t, z, z + d->nq);
  int status = nsdae_terms_need(T, RATE_TERMS);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status == NSDAE_OK) status = nsdae_kinematics_at(T, T->v, zdot);
  if (status < 0) return nsdae_progress_code(status, s->error);
  int code = accelerations(p, T, zdot + d->nq);
  if (!whole || code != 0) return code;
  memcpy(zdot + nsdae_penalty_at(d).lambda, at->lambda, forces_size(d));
  status = powers(p, T, zdot, zdot + nsdae_penalty_at(d).work);
  return nsdae_progress_code(status, s->error);
}

int nsdae_penalty_powers(double t, const double *y, const double *ydot, double *rate, void *user)
{
  nsdae_penalty_equations *p = user;
  nsdae_terms *T = &p->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  const nsdae_penalty_forces *at = &p->at;
  int status = nsdae_penalty_evaluate(p, t, y);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, RATE_TERMS);
  if (status < 0) return nsdae_progress_code(status, p->stepper->error);
  nsdae_penalty_take(p, y);
  for (int j = 0; j < d->f; j++) at->v_s[j] = nsdae_terms_slide_rate(T, j, T->v);
  return nsdae_progress_code(powers(p, T, ydot, rate), p->stepper->error);
}

int nsdae_penalty_evaluate(nsdae_penalty_equations *p, double t, const double *qv)
{
  nsdae_terms *T = &p->stepper->middle;
  nsdae_terms_at(T, t, qv, qv + T->system->dims.nq);
  int status = nsdae_terms_need(T, CONTACT_TERMS);
  if (status == NSDAE_OK) contact_forces(p, T);
  return status;
}

void nsdae_penalty_equations_layout(nsdae_penalty_equations *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->stepper->system->dims;
  nsdae_penalty_forces *at = &p->at;
  long k = d->k, kt = k * d->nt, f = d->f;
  p->room = NSDAE_ARENA_DOUBLES(arena, d->nq + d->nv);
  nsdae_power_layout(&p->power, p->stepper->system, arena);
  nsdae_newton_kkt_layout(&p->newton, p->stepper->system, (int)(k + kt + f),
                          p->stepper->options->rank_tol, arena);
  p->border_force = NSDAE_ARENA_INTS(arena, k + kt + f);
  p->border_room = NSDAE_ARENA_DOUBLES(arena, k + kt + f);
  p->basis = NSDAE_ARENA_DOUBLES(arena, nsdae_kkt_basis_size(&p->stepper->kkt));
  at->lambda = NSDAE_ARENA_DOUBLES(arena, d->m + k + kt + f);
  at->normal = at->lambda ? at->lambda + d->m : NULL;
  at->tangential = at->lambda ? at->normal + k : NULL;
  at->frictional_joint = at->lambda ? at->tangential + kt : NULL;
  at->v_n = NSDAE_ARENA_DOUBLES(arena, k);
  at->v_t = NSDAE_ARENA_DOUBLES(arena, kt);
  at->v_s = NSDAE_ARENA_DOUBLES(arena, f);
  at->U = NSDAE_ARENA_DOUBLES(arena, d->nv * f);
  at->D = NSDAE_ARENA_DOUBLES(arena, d->m * f);
}

/* ---- base */

static void lay(nsdae_penalty_base *b, nsdae_tracking *tracking, const nsdae_stepper *s,
                nsdae_memory_part *part)
{
  const nsdae_dims *d = &s->system->dims;
  double **of_contact[] = {&b->since, &b->start_rate, &b->mass, &b->impulse, &b->peak};
  b->t = nsdae_memory_reals(part, NSDAE_OF_ALL(1));
  b->first = nsdae_memory_reals(part, NSDAE_OF_ALL(1));
  b->qv = nsdae_memory_reals(part, NSDAE_OF_ALL((size_t)d->nq + (size_t)d->nv));
  for (int i = 0; i < 5; i++) *of_contact[i] = nsdae_memory_reals(part, NSDAE_BY_SLOT(1));
  b->impulse_t = nsdae_memory_reals(part, NSDAE_BY_SLOT((size_t)d->nt));
  b->steps = nsdae_memory_wholes(part, NSDAE_OF_ALL(1));
  b->is_stiff = nsdae_memory_wholes(part, NSDAE_OF_ALL(1));
  b->closed = nsdae_memory_wholes(part, NSDAE_BY_SLOT(1));
  if (s->system->tracked) nsdae_tracking_lay(tracking, s->system, part);
}

void nsdae_penalty_base_lay(const nsdae_stepper *s, nsdae_memory_part *part)
{
  nsdae_penalty_base base;
  nsdae_tracking tracking;
  lay(&base, &tracking, s, part);
}

void nsdae_penalty_base_find(nsdae_penalty_base *b, nsdae_tracking *tracking,
                             const nsdae_stepper *s, nsdae_memory *memory)
{
  nsdae_memory_part part = {
      .real = memory->real, .whole = memory->whole, .slots = (size_t)s->system->dims.k};
  lay(b, tracking, s, &part);
}
