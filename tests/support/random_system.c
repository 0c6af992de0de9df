#include "random_system.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static double between(random_system *r, double low, double high)
{
  return low + (high - low) * random_uniform(&r->state);
}

static int chance(random_system *r, double p)
{
  return random_uniform(&r->state) < p;
}

/* The calls */

/* Counts the call and spoils it where that is asked for. */
static int spoil(random_system *r, enum random_term term, double *out, int entries)
{
  const random_fault *f = &r->fault;
  long call = r->calls[term]++;
  if (++r->all_calls > r->calls_max) return -99;
  if (f->term != (int)term || call < f->at || (call > f->at && !f->for_ever)) return 0;
  if (f->code == 0 && entries > 0) out[f->entry % entries] = f->value;
  return f->code;
}

static double dot(const double *a, const double *b, int n)
{
  double sum = 0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

static double row_value(const random_row *w, double t, const double *q, int n)
{
  return dot(w->c, q, n) + w->b * sin(dot(w->B, q, n)) - w->rate * t - w->offset;
}

/* d row / dq_i h_i */
static double row_slope(const random_system *r, const random_row *w, const double *q, int i)
{
  return (w->c[i] + w->b * cos(dot(w->B, q, r->dims.nq)) * w->B[i]) * r->h[i];
}

/* The second derivative along v, of a row without mixed terms in t; h is constant. */
static double row_bend(const random_system *r, const random_row *w, const double *q,
                       const double *v)
{
  double along = 0;
  for (int i = 0; i < r->dims.nq; i++) along += w->B[i] * r->h[i] * v[i];
  return -w->b * sin(dot(w->B, q, r->dims.nq)) * along * along;
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  random_system *r = user;
  (void)t;
  for (int i = 0; i < r->dims.nv; i++) M[i * ldm + i] = r->m[i] * (1 + r->a[i] * sin(q[i]));
  return spoil(r, RANDOM_MASS, M, r->dims.nv * ldm);
}

static int mass_blocks(double t, const double *q, double *M, void *user)
{
  random_system *r = user;
  (void)t;
  for (int i = 0; i < r->dims.nv; i++) M[i] = r->m[i] * (1 + r->a[i] * sin(q[i]));
  return spoil(r, RANDOM_MASS, M, r->dims.nv);
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  random_system *r = user;
  (void)t;
  for (int i = 0; i < r->dims.nv; i++)
    F[i] = -r->h[i] * (r->m[i] * r->a[i] * cos(q[i]) * v[i] * v[i] / 2 + r->g[i] + r->s[i] * q[i]) -
           r->damp[i] * v[i];
  return spoil(r, RANDOM_FORCE, F, r->dims.nv);
}

/* -dF_i / dv_i */
static int damping(double t, const double *q, const double *v, double *D, int ldd, void *user)
{
  random_system *r = user;
  (void)t;
  for (int i = 0; i < r->dims.nv; i++)
    D[i * (ldd + 1)] = r->h[i] * r->m[i] * r->a[i] * cos(q[i]) * v[i] + r->damp[i];
  return spoil(r, RANDOM_DAMPING, D, r->dims.nv * ldd);
}

/* -dF_i / dq_i h_i */
static int stiffness(double t, const double *q, const double *v, double *K, int ldk, void *user)
{
  random_system *r = user;
  (void)t;
  for (int i = 0; i < r->dims.nv; i++)
    K[i * (ldk + 1)] =
        r->h[i] * r->h[i] * (r->s[i] - r->m[i] * r->a[i] * sin(q[i]) * v[i] * v[i] / 2);
  return spoil(r, RANDOM_STIFFNESS, K, r->dims.nv * ldk);
}

static int potential(double t, const double *q, double *energy, void *user)
{
  random_system *r = user;
  (void)t;
  *energy = 0;
  for (int i = 0; i < r->dims.nq; i++) *energy += (r->g[i] + r->s[i] * q[i] / 2) * q[i];
  return spoil(r, RANDOM_POTENTIAL, energy, 1);
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  random_system *r = user;
  (void)t;
  (void)q;
  for (int i = 0; i < r->dims.nq; i++) qdot[i] = r->h[i] * v[i];
  return spoil(r, RANDOM_KINEMATICS, qdot, r->dims.nq);
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  random_system *r = user;
  for (int j = 0; j < r->dims.m; j++) phi[j] = row_value(&r->phi[j], t, q, r->dims.nq);
  return spoil(r, RANDOM_CONSTRAINT, phi, r->dims.m);
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  random_system *r = user;
  (void)t;
  for (int j = 0; j < r->dims.m; j++)
    for (int i = 0; i < r->dims.nv; i++) J[i * ldj + j] = row_slope(r, &r->phi[j], q, i);
  return spoil(r, RANDOM_JACOBIAN, J, r->dims.nv * ldj);
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  random_system *r = user;
  (void)t;
  for (int j = 0; j < r->dims.m; j++) {
    phi_t[j] = -r->phi[j].rate;
    omega[j] = row_bend(r, &r->phi[j], q, v);
  }
  int second = r->fault.entry % 2;
  return spoil(r, RANDOM_BIAS, second ? omega : phi_t, r->dims.m);
}

static int gap(double t, const double *q, double *g, void *user)
{
  random_system *r = user;
  for (int i = 0; i < r->dims.k; i++) g[i] = row_value(&r->gap[i], t, q, r->dims.nq);
  return spoil(r, RANDOM_GAP, g, r->dims.k);
}

static int normal(double t, const double *q, double *W, int ldw, void *user)
{
  random_system *r = user;
  (void)t;
  for (int i = 0; i < r->dims.k; i++)
    for (int j = 0; j < r->dims.nv; j++) W[i * ldw + j] = row_slope(r, &r->gap[i], q, j);
  return spoil(r, RANDOM_NORMAL, W, r->dims.k * ldw);
}

static int tangent(double t, const double *q, double *W, int ldw, void *user)
{
  random_system *r = user;
  (void)t;
  (void)q;
  int n = r->dims.nv, columns = r->dims.k * r->dims.nt;
  for (int j = 0; j < columns; j++) memcpy(W + j * ldw, r->W_T + j * n, (size_t)n * sizeof *W);
  return spoil(r, RANDOM_TANGENT, W, columns * ldw);
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  random_system *r = user;
  (void)t;
  (void)q;
  for (int i = 0; i < r->dims.k; i++) w_n[i] = -r->gap[i].rate;
  int second = w_t && r->fault.entry % 2, count = r->dims.k * r->dims.nt;
  for (int j = 0; w_t && j < count; j++) w_t[j] = r->w_T[j];
  return spoil(r, RANDOM_CONTACT_BIAS, second ? w_t : w_n, second ? count : r->dims.k);
}

static int acceleration(double t, const double *q, const double *v, double *omega_n,
                        double *omega_t, double *omega_s, void *user)
{
  random_system *r = user;
  (void)t;
  for (int i = 0; i < r->dims.k; i++) omega_n[i] = row_bend(r, &r->gap[i], q, v);
  for (int j = 0; omega_t && j < r->dims.k * r->dims.nt; j++) omega_t[j] = 0;
  for (int j = 0; omega_s && j < r->dims.f; j++) omega_s[j] = 0;
  return spoil(r, RANDOM_ACCELERATION, omega_n ? omega_n : omega_s,
               omega_n ? r->dims.k : r->dims.f);
}

static int frictional_joint(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  random_system *r = user;
  (void)t;
  (void)q;
  int n = r->dims.nv;
  for (int j = 0; j < r->dims.f; j++) {
    memcpy(W + j * ldw, r->W_S + j * n, (size_t)n * sizeof *W);
    w[j] = r->w_S[j];
  }
  return spoil(r, RANDOM_SLIDE, W, r->dims.f * ldw);
}

/* The data */

/* A positive number of that size; with extreme data its logarithm is uniform over 20 decades. */
static double size_of(random_system *r, int kind, double typical)
{
  double x = typical * between(r, 0.3, 3);
  return kind == RANDOM_EXTREME ? x * pow(10, between(r, -10, 10)) : x;
}

static double sign(random_system *r)
{
  return chance(r, 0.5) ? 1 : -1;
}

/* A unit vector of nq entries, some of them zero. */
static void direction(random_system *r, double *c)
{
  int n = r->dims.nq;
  double length = 0;
  while (!(length > 0.1)) {
    for (int i = 0; i < n; i++) c[i] = chance(r, 0.3) ? 0 : between(r, -1, 1);
    length = sqrt(dot(c, c, n));
  }
  for (int i = 0; i < n; i++) c[i] /= length;
}

/* c is at least 1/2 off the rows before, so that no two say the same; b and B leave that so. */
static void draw_row(random_system *r, random_row *rows, int count)
{
  int n = r->dims.nq, near = 1;
  random_row *w = &rows[count];
  *w = (random_row){0};
  for (int tries = 0; near && tries < 100; tries++) {
    direction(r, w->c);
    near = 0;
    for (int i = 0; i < count; i++) near |= fabs(dot(w->c, rows[i].c, n)) > 0.5;
  }
  direction(r, w->B);
  w->b = r->turns ? between(r, 0, 0.2) : 0;
  w->rate = r->rheonomic ? between(r, -0.3, 0.3) : 0;
}

static void draw_dims(random_system *r)
{
  nsdae_dims *d = &r->dims;
  d->nq = d->nv = 1 + random_below(&r->state, RANDOM_NQ);
  int most = d->nq - 1 < RANDOM_M ? d->nq - 1 : RANDOM_M;
  d->m = random_below(&r->state, most + 1);
  d->k = random_below(&r->state, RANDOM_K + 1);
  d->nt = d->k ? random_below(&r->state, RANDOM_NT + 1) : 0;
  d->f = d->m && chance(r, 0.5) ? 1 + random_below(&r->state, d->m) : 0;
  r->rheonomic = chance(r, 0.4);
  r->turns = chance(r, 0.6);
  for (int i = 0; i <= RANDOM_POTENTIAL; i++) r->given |= (unsigned)chance(r, 0.7) << i;
}

static void draw_inertia(random_system *r, int kind)
{
  int kinematic = r->given >> RANDOM_KINEMATICS & 1, springs = chance(r, 0.5);
  for (int i = 0; i < r->dims.nq; i++) {
    r->h[i] = kinematic ? sign(r) * between(r, 0.5, 2) : 1;
    r->m[i] = size_of(r, kind, 1);
    r->a[i] = r->turns ? between(r, -0.4, 0.4) : 0;
    r->g[i] = chance(r, 0.7) ? sign(r) * size_of(r, kind, 5) : 0;
    r->s[i] = springs ? size_of(r, kind, 20) : 0;
    r->damp[i] = chance(r, 0.3) ? size_of(r, kind, 0.3) : 0;
    r->q0[i] = between(r, -1, 1);
    r->v0[i] = chance(r, 0.7) ? sign(r) * size_of(r, kind, 1) : 0;
  }
}

static void draw_contacts(random_system *r)
{
  const nsdae_dims *d = &r->dims;
  for (int i = 0; i < d->k; i++) {
    draw_row(r, r->gap, i);
    /* closed, at some distance, or just so at a distance */
    double apart = chance(r, 0.3) ? 0 : chance(r, 0.1) ? 1e-18 : between(r, 0, 0.5);
    r->gap[i].offset = row_value(&r->gap[i], 0, r->q0, d->nq) - apart;
    r->mu[i] = chance(r, 0.3) ? 0 : between(r, 0, 1);
    r->e_n[i] = chance(r, 0.3) ? 0 : chance(r, 0.2) ? 1 : between(r, 0, 1);
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++) {
      direction(r, r->W_T + j * d->nv);
      r->w_T[j] = r->rheonomic ? between(r, -0.3, 0.3) : 0;
    }
  }
}

static void draw_constraints(random_system *r)
{
  const nsdae_dims *d = &r->dims;
  for (int j = 0; j < d->m; j++) {
    draw_row(r, r->phi, j);
    r->phi[j].offset = row_value(&r->phi[j], 0, r->q0, d->nq);
  }
  for (int j = 0; j < d->f; j++) {
    direction(r, r->W_S + j * d->nv);
    r->w_S[j] = r->rheonomic ? between(r, -0.3, 0.3) : 0;
    r->slide_mu[j] = chance(r, 0.2) ? 0 : between(r, 0, 0.5);
  }
}

/* v0 on Phi_q v = -Phi_t, by Kaczmarz's sweeps over the rows: they are far from parallel. */
static void project_start(random_system *r)
{
  const nsdae_dims *d = &r->dims;
  for (int sweep = 0; sweep < 2000; sweep++)
    for (int j = 0; j < d->m; j++) {
      double row[RANDOM_NQ];
      for (int i = 0; i < d->nv; i++) row[i] = row_slope(r, &r->phi[j], r->q0, i);
      double off = (dot(row, r->v0, d->nv) - r->phi[j].rate) / dot(row, row, d->nv);
      for (int i = 0; i < d->nv; i++) r->v0[i] -= off * row[i];
    }
}

void random_system_draw(random_system *r, uint64_t seed, int kind)
{
  *r = (random_system){.state = seed, .fault.term = -1, .calls_max = 20000000};
  draw_dims(r);
  uint64_t apart = ~seed; /* the other data do not depend on these */
  for (int i = RANDOM_DAMPING; i <= RANDOM_STIFFNESS; i++)
    r->given |= (unsigned)(random_uniform(&apart) < 0.5) << i;
  draw_inertia(r, kind);
  draw_constraints(r);
  draw_contacts(r);
  project_start(r);
  r->by_blocks = seed % 4 == 3;
}

/* Whether the library calls it. */
static int has(const random_system *r, int term)
{
  const nsdae_dims *d = &r->dims;
  int given = r->given >> term & 1;
  switch (term) {
  case RANDOM_CONSTRAINT:
    return d->m > 0;
  case RANDOM_JACOBIAN:
  case RANDOM_BIAS:
    return d->m > 0 && given;
  case RANDOM_GAP:
    return d->k > 0;
  case RANDOM_NORMAL:
  case RANDOM_CONTACT_BIAS:
    return d->k > 0 && given;
  case RANDOM_TANGENT:
    return d->k > 0 && d->nt > 0;
  case RANDOM_ACCELERATION:
    return d->k + d->f > 0 && given;
  case RANDOM_SLIDE:
    return d->f > 0;
  case RANDOM_KINEMATICS:
  case RANDOM_POTENTIAL:
  case RANDOM_DAMPING:
  case RANDOM_STIFFNESS:
    return given;
  default:
    return 1;
  }
}

void random_system_spoil(random_system *r, uint64_t seed)
{
  static const double values[] = {NAN,   INFINITY, 1e308,  1e200,   1e-310, 0,
                                  1e20,  DBL_MAX,  1e100,  DBL_MIN, 5e-324, 1e12,
                                  1e-20, 1e155,    1e-160, 1,       1e6};
  uint64_t state = seed;
  random_fault *f = &r->fault;
  do f->term = random_below(&state, RANDOM_POTENTIAL + 1);
  while (!has(r, f->term));
  uint64_t apart = ~seed;
  int other = RANDOM_DAMPING + random_below(&apart, 2);
  if (random_uniform(&apart) < 0.2 && has(r, other)) f->term = other;
  /* the start alone calls everything a few times: early calls, and any of a short run */
  f->at = (long)pow(10, 3.5 * random_uniform(&state)) - 1;
  f->for_ever = random_uniform(&state) < 0.25;
  f->code = random_uniform(&state) < 0.3 ? random_below(&state, 2) * 2 - 1 : 0;
  f->entry = random_below(&state, 1000);
  f->value = values[random_below(&state, sizeof values / sizeof *values)];
  if (random_uniform(&state) < 0.5) f->value = -f->value;
}

void random_system_rewind(random_system *r)
{
  memset(r->calls, 0, sizeof r->calls);
  r->all_calls = 0;
}

static void set_contacts(nsdae_system *s, const random_system *r)
{
  nsdae_system_set_gap(s, gap);
  if (has(r, RANDOM_NORMAL)) nsdae_system_set_gap_normal(s, normal);
  if (has(r, RANDOM_TANGENT)) nsdae_system_set_gap_tangent(s, tangent);
  if (has(r, RANDOM_CONTACT_BIAS)) nsdae_system_set_contact_bias(s, contact_bias);
  for (int i = 0; i < r->dims.k; i++)
    nsdae_system_set_contact(s, i, r->dims.nt ? r->mu[i] : 0, r->e_n[i], 0);
}

static void set_constraints(nsdae_system *s, const random_system *r)
{
  nsdae_system_set_constraint(s, constraint);
  if (has(r, RANDOM_JACOBIAN)) nsdae_system_set_constraint_jacobian(s, jacobian);
  if (has(r, RANDOM_BIAS)) nsdae_system_set_constraint_bias(s, bias);
  if (r->dims.f > 0) nsdae_system_set_frictional_joint_tangent(s, frictional_joint);
  for (int j = 0; j < r->dims.f; j++) {
    double mu = r->slide_mu[j]; /* of three joints one has a bound, too */
    nsdae_system_set_frictional_joint(s, j, j, mu);
    if (fmod(1e6 * mu, 3) < 1) nsdae_system_set_friction_bound(s, j, 0.5 * mu);
  }
}

static void set_names(nsdae_system *s, const nsdae_dims *d)
{
  static const char letter[] = "qvcks"; /* in the order of enum nsdae_name_kind */
  const int count[] = {d->nq, d->nv, d->m, d->k, d->f};
  for (int kind = 0; kind < 5; kind++)
    for (int i = 0; i < count[kind]; i++) {
      char name[16];
      snprintf(name, sizeof name, "%c_%d", letter[kind], i);
      nsdae_system_set_name(s, kind, i, name, "");
    }
}

nsdae_system *random_system_make(random_system *r)
{
  nsdae_system *s;
  if (nsdae_system_create(&r->dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, r);
  const int ones[RANDOM_NQ] = {1, 1, 1, 1, 1, 1};
  if (r->by_blocks) {
    nsdae_system_set_blocks(s, r->dims.nv, ones, ones);
    nsdae_system_set_mass_blocks(s, mass_blocks);
  } else {
    nsdae_system_set_mass(s, mass);
  }
  nsdae_system_set_force(s, force);
  if (!r->by_blocks && has(r, RANDOM_DAMPING)) nsdae_system_set_force_damping(s, damping);
  if (!r->by_blocks && has(r, RANDOM_STIFFNESS)) nsdae_system_set_force_stiffness(s, stiffness);
  if (has(r, RANDOM_KINEMATICS)) nsdae_system_set_kinematics(s, kinematics);
  if (has(r, RANDOM_POTENTIAL)) nsdae_system_set_potential(s, potential);
  if (has(r, RANDOM_ACCELERATION)) nsdae_system_set_contact_acceleration(s, acceleration);
  if (r->dims.m > 0) set_constraints(s, r);
  if (r->dims.k > 0) set_contacts(s, r);
  set_names(s, &r->dims);
  return s;
}
