/* A contact problem with constant matrices, solved by itself: everything that a step would give it
 * is set by hand. */
#ifndef NSDAE_TESTS_CONTACT_FIXTURE_H
#define NSDAE_TESTS_CONTACT_FIXTURE_H

#include "check.h"

#include <nsdae/sim.h>

#include "contacts.h"
#include "system_impl.h"

enum { MOST_V = 8, MOST_M = 3, MOST_K = 6 };

typedef struct fixture {
  nsdae_dims dims;
  /* the model, column-major */
  double M[MOST_V * MOST_V], J[MOST_M * MOST_V], phi_t[MOST_M];
  double gap[MOST_K], W_N[MOST_V * MOST_K], W_T[MOST_V * MOST_K * 2];
  double w_n[MOST_K], w_t[MOST_K * 2], W_S[MOST_V * MOST_M], w_s[MOST_M];
  /* the velocities before, and without contacts; after */
  double before[MOST_V], free[MOST_V], v[MOST_V];
  double lambda_free[MOST_M], lambda[MOST_M];

  nsdae_system *system;
  nsdae_differences differences;
  nsdae_terms terms;
  nsdae_evals evals;
  nsdae_error error;
  nsdae_kkt kkt;
  nsdae_contacts contacts;
  nsdae_impulses impulses;
  int *memory;
  nsdae_arena arena;
} fixture;

static inline void fixture_columns(int rows, int columns, const double *from, double *to, int ld)
{
  for (int j = 0; j < columns; j++) memcpy(to + j * ld, from + j * rows, (size_t)rows * sizeof *to);
}

static inline int fixture_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const fixture *f = user;
  (void)t;
  (void)q;
  fixture_columns(f->dims.nv, f->dims.nv, f->M, M, ldm);
  return 0;
}

static inline int fixture_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)F;
  (void)user;
  return 0;
}

static inline int fixture_zero(double t, const double *q, double *phi, void *user)
{
  (void)t;
  (void)q;
  (void)phi;
  (void)user;
  return 0;
}

static inline int fixture_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const fixture *f = user;
  (void)t;
  (void)q;
  fixture_columns(f->dims.m, f->dims.nv, f->J, J, ldj);
  return 0;
}

static inline int fixture_gap(double t, const double *q, double *gap, void *user)
{
  const fixture *f = user;
  (void)t;
  (void)q;
  memcpy(gap, f->gap, (size_t)f->dims.k * sizeof *gap);
  return 0;
}

static inline int fixture_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const fixture *f = user;
  (void)t;
  (void)q;
  fixture_columns(f->dims.nv, f->dims.k, f->W_N, W, ldw);
  return 0;
}

static inline int fixture_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const fixture *f = user;
  (void)t;
  (void)q;
  fixture_columns(f->dims.nv, f->dims.k * f->dims.nt, f->W_T, W, ldw);
  return 0;
}

static inline int fixture_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const fixture *f = user;
  (void)t;
  (void)q;
  memcpy(w_n, f->w_n, (size_t)f->dims.k * sizeof *w_n);
  if (w_t) memcpy(w_t, f->w_t, (size_t)f->dims.k * (size_t)f->dims.nt * sizeof *w_t);
  return 0;
}

static inline int fixture_slide(double t, const double *q, double *W, int ldw, double *w,
                                void *user)
{
  const fixture *f = user;
  (void)t;
  (void)q;
  fixture_columns(f->dims.nv, f->dims.f, f->W_S, W, ldw);
  memcpy(w, f->w_s, (size_t)f->dims.f * sizeof *w);
  return 0;
}

/* Integers of the bases. */
static inline long fixture_memory(const fixture *f)
{
  return (long)f->dims.k * f->contacts.rows_most + 3L * f->contacts.slides.count;
}

static inline void fixture_layout(void *object, nsdae_arena *arena)
{
  fixture *f = object;
  nsdae_differences_layout(&f->differences, arena);
  nsdae_terms_layout(&f->terms, arena);
  nsdae_kkt_layout(&f->kkt, arena);
  nsdae_contacts_layout(&f->contacts, &f->dims, arena);
  nsdae_impulses_layout(&f->impulses, &f->dims, arena);
  f->memory = NSDAE_ARENA_INTS(arena, fixture_memory(f));
}

/* The sizes; M is the identity and the rest zero. */
static inline void fixture_begin(fixture *f, nsdae_dims dims)
{
  memset(f, 0, sizeof *f);
  f->dims = dims;
  f->dims.nv = dims.nq;
  for (int i = 0; i < dims.nq; i++) f->M[i * dims.nq + i] = 1;
  assert_int_equal(nsdae_system_create(&dims, &f->system, NULL), NSDAE_OK);
  f->system->user = f;
  f->system->call.mass = fixture_mass;
  f->system->call.force = fixture_force;
  f->system->call.constraint = fixture_zero;
  f->system->call.constraint_jacobian = fixture_jacobian;
  f->system->call.gap = fixture_gap;
  f->system->call.gap_normal = fixture_normal;
  f->system->call.gap_tangent = fixture_tangent;
  f->system->call.contact_bias = fixture_bias;
  f->system->call.frictional_joint_tangent = fixture_slide;
}

/* After the model and the coefficients are set. */
static inline void fixture_build(fixture *f, int polygon)
{
  f->differences.system = f->terms.system = f->contacts.system = f->system;
  f->terms.differences = &f->differences;
  f->terms.error = f->contacts.error = &f->error;
  f->terms.evals = &f->evals;
  f->kkt =
      (nsdae_kkt){.n = f->dims.nv, .m = f->dims.m, .blocks = &f->system->blocks, .rank_tol = 1e-8};
  nsdae_lcp_options_default(&f->contacts.lcp.options);
  nsdae_contacts_laws(&f->contacts, polygon);
  assert_int_equal(nsdae_arena_build(&f->arena, fixture_layout, f), NSDAE_OK);
  nsdae_contacts_remember(&f->contacts, f->memory);
  assert_int_equal(nsdae_cones_open(&f->contacts.cones), NSDAE_OK);
}

/* M and J of the model. */
static inline void fixture_factor(fixture *f)
{
  nsdae_rows rows = f->terms.by.jacobian;
  rows.value = f->J;
  assert_int_equal(nsdae_kkt_factor(&f->kkt, f->M, &rows), NSDAE_OK);
}

/* The next problem starts cold. */
static inline void fixture_forget(fixture *f)
{
  memset(f->memory, 0, (size_t)fixture_memory(f) * sizeof *f->memory);
}

static inline void fixture_end(fixture *f)
{
  nsdae_cones_close(&f->contacts.cones);
  nsdae_arena_release(&f->arena);
  nsdae_system_destroy(&f->system);
}

/* Solves for v, lambda of before, free, lambda_free. */
static inline int fixture_solve(fixture *f)
{
  const double q[MOST_V] = {0};
  double size[MOST_V];
  const unsigned which = NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN | NSDAE_TERM_GAP |
                         NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS |
                         NSDAE_TERM_SLIDE;
  nsdae_terms_at(&f->terms, 0, q, f->before);
  assert_int_equal(nsdae_terms_need(&f->terms, which), NSDAE_OK);
  assert_int_equal(nsdae_terms_factor(&f->terms, f->terms.M, &f->kkt, 1), NSDAE_OK);
  int closed[MOST_K];
  for (int i = 0; i < f->dims.k; i++) closed[i] = !(f->terms.gap[i] > nsdae_terms_touch(&f->terms));
  nsdae_contacts_close_marked(&f->contacts, closed, &f->impulses);
  nsdae_contacts_before(&f->contacts, &f->terms, f->before, 0);
  memcpy(f->v, f->free, sizeof f->v);
  memcpy(size, f->free, sizeof size);
  memcpy(f->lambda, f->lambda_free, sizeof f->lambda);
  return nsdae_contacts_solve(&f->contacts, &f->terms, &f->kkt, size, f->v, f->lambda);
}

/* The velocity without contacts is the one before: an impact alone. */
static inline int fixture_impact(fixture *f)
{
  memcpy(f->free, f->before, sizeof f->free);
  return fixture_solve(f);
}

static inline double fixture_dot(int n, const double *a, const double *b)
{
  double sum = 0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* p += M v */
static inline void fixture_add_mass(const fixture *f, const double *v, double *p)
{
  int n = f->dims.nv;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) p[i] += f->M[j * n + i] * v[j];
}

/* T = v^T M v / 2 */
static inline double fixture_kinetic(const fixture *f, const double *v)
{
  double p[MOST_V] = {0};
  fixture_add_mass(f, v, p);
  return fixture_dot(f->dims.nv, p, v) / 2;
}

/* What holds of every solution: M (v - free) + J^T (lambda - lambda_free) = W Lambda, J v is as
 * before, the contact laws in the form of the header of system.h. tol: relative to the largest
 * impulse. */
static inline void fixture_expect_laws(const fixture *f, double tol)
{
  const nsdae_impulses *c = &f->impulses;
  int n = f->dims.nv, nt = f->dims.nt;
  double largest = 1;
  for (int i = 0; i < f->dims.k; i++) largest = fmax(largest, c->normal[i]);
  for (int j = 0; j < f->dims.m; j++) largest = fmax(largest, fabs(f->lambda[j]));
  tol *= largest;
  for (int i = 0; i < n; i++) {
    double sum = 0;
    for (int j = 0; j < n; j++) sum += f->M[j * n + i] * (f->v[j] - f->free[j]);
    for (int j = 0; j < f->dims.m; j++)
      sum += f->J[i * f->dims.m + j] * (f->lambda[j] - f->lambda_free[j]);
    for (int j = 0; j < f->dims.k; j++) sum -= f->W_N[j * n + i] * c->normal[j];
    for (int j = 0; j < f->dims.k * nt; j++) sum -= f->W_T[j * n + i] * c->tangential[j];
    for (int j = 0; j < f->dims.f; j++) sum -= f->W_S[j * n + i] * c->frictional_joint_impulse[j];
    assert_near(sum, 0, tol);
  }
  for (int j = 0; j < f->dims.m; j++) {
    double sum = 0;
    for (int i = 0; i < n; i++) sum += f->J[i * f->dims.m + j] * (f->v[i] - f->free[i]);
    assert_near(sum, 0, tol);
  }
  for (int i = 0; i < f->dims.k; i++) {
    const nsdae_coefficients *e = &f->system->contact[i];
    double normal = c->normal[i], force = 0, slip = 0, power = 0;
    const nsdae_law law = nsdae_law_make(nt, e->mu, f->contacts.edges, NULL);
    double mu = law.kind == NSDAE_FRICTIONLESS ? 0 : e->mu;
    if (f->gap[i] > 0) {
      assert_true(normal == 0 && c->mode[i] == NSDAE_MODE_OPEN);
      continue;
    }
    double after = fixture_dot(n, f->W_N + i * n, f->v) + f->w_n[i];
    double before = fixture_dot(n, f->W_N + i * n, f->before) + f->w_n[i];
    double xi = after + e->e_n * before;
    assert_near(c->after[i], after, tol);
    assert_near(c->before[i], before, tol);
    assert_true(normal >= 0);
    assert_true(xi >= -tol);
    assert_near(fmin(normal, xi), 0, tol); /* complementary */
    for (int j = i * nt; j < (i + 1) * nt; j++) {
      double t = c->tangential[j];
      double xi_t = fixture_dot(n, f->W_T + j * n, f->v) + f->w_t[j] +
                    e->e_t * (fixture_dot(n, f->W_T + j * n, f->before) + f->w_t[j]);
      force += t * t;
      slip += xi_t * xi_t;
      power += t * xi_t;
    }
    assert_at_most(sqrt(force), mu * normal + tol);
    /* against the slip, as far as it can where it slips; a polygon of p corners is off by pi/p */
    double corner = law.kind == NSDAE_POLYGON ? cos(3.2 / (law.rows - 2)) : 1;
    assert_at_most(power, -mu * normal * sqrt(slip) * corner + tol);
    if (normal == 0) assert_int_equal(c->mode[i], NSDAE_MODE_OPEN);
    if (normal > tol) assert_int_not_equal(c->mode[i], NSDAE_MODE_OPEN);
    if (sqrt(slip) > tol && normal > tol) assert_int_equal(c->mode[i], NSDAE_MODE_SLIP);
    if (sqrt(force) < mu * normal * corner - tol) assert_int_equal(c->mode[i], NSDAE_MODE_STICK);
  }
}

#endif
