/* Newton's matrix M + D/cj + K/cj^2 of random systems against D and K by formula: callbacks and
 * coloured differences, dense and by blocks, and what callbacks do wrong. The residuals of the
 * equations of motion against their terms.
 *
 * Each link l couples two blocks r, c through x = w . q_r - u . q_c and its rate s:
 *   f = -(d (s + s^3/10) + k (x + x^3/10)),  F_r += f w,  F_c -= f u
 * and within a block F_i += g v_i+1, F_i+1 -= g v_i. dq_i/dt = v_i + v_i+1/3 in a block, so that
 * K = -(dF/dq) H is not symmetric. */
#include "newton_kkt.h"
#include "listed.h"
#include "check.h"

#include "allocator.h"
#include "support/random.h"

enum { BLOCKS = 12, SIZE = 4, NV = BLOCKS * SIZE, LINKS = 2 * BLOCKS };

typedef struct link {
  int block[2];
  double w[2][SIZE], d, k;
} link;

typedef struct model {
  int sizes[BLOCKS], first[BLOCKS + 1], blocks, links;
  int shown; /* links that the list callbacks show */
  link link[LINKS];
  double g, M[NV];
  int bad, code; /* what a callback does wrong */
  long forces, listed;
  long fail_at; /* evaluation of F that fails, < 0: none */
} model;

enum { NO_BLOCK = 1, NO_VALUE, NOT_A_NUMBER, CODE };

static double along(const model *p, const link *l, const double *y)
{
  double sum = 0;
  for (int side = 0; side < 2; side++)
    for (int i = 0; i < p->sizes[l->block[side]]; i++)
      sum += l->w[side][i] * y[p->first[l->block[side]] + i];
  return sum;
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const model *p = user;
  (void)t, (void)q;
  for (int b = 0; b < p->blocks; b++)
    for (int i = p->first[b]; i < p->first[b + 1]; i++)
      qdot[i] = v[i] + (i + 1 < p->first[b + 1] ? v[i + 1] / 3 : 0);
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  model *p = user;
  (void)t;
  for (int b = 0; b < p->blocks; b++)
    for (int i = p->first[b]; i + 1 < p->first[b + 1]; i++) {
      F[i] += p->g * v[i + 1];
      F[i + 1] -= p->g * v[i];
    }
  for (int e = 0; e < p->links; e++) {
    const link *l = &p->link[e];
    double x = along(p, l, q), s = along(p, l, v);
    double f = -(l->d * (s + s * s * s / 10) + l->k * (x + x * x * x / 10));
    for (int side = 0; side < 2; side++)
      for (int i = 0; i < p->sizes[l->block[side]]; i++)
        F[p->first[l->block[side]] + i] += f * l->w[side][i];
  }
  return p->forces++ == p->fail_at ? p->code : 0;
}

/* X [nv x nv] of the links e0 .. e1 - 1: D (along_q = 0) or K. */
static void formula(const model *p, int e0, int e1, int along_q, const double *q, const double *v,
                    double *X, int ld)
{
  for (int e = e0; e < e1; e++) {
    const link *l = &p->link[e];
    double x = along(p, l, along_q ? q : v), row[NV] = {0}, rate[NV] = {0};
    double rise = (along_q ? l->k : l->d) * (1 + 0.3 * x * x);
    for (int side = 0; side < 2; side++)
      for (int i = 0; i < p->sizes[l->block[side]]; i++) {
        int at = p->first[l->block[side]] + i;
        row[at] = l->w[side][i];
        rate[at] += row[at];
        if (along_q && i + 1 < p->sizes[l->block[side]]) rate[at + 1] += row[at] / 3;
      }
    for (int j = 0; j < p->first[p->blocks]; j++)
      for (int i = 0; i < p->first[p->blocks]; i++) X[i + j * ld] += rise * row[i] * rate[j];
  }
  for (int b = 0; b < p->blocks && !along_q; b++)
    for (int i = p->first[b]; i + 1 < p->first[b + 1]; i++) {
      X[i + (i + 1) * ld] -= p->g;
      X[i + 1 + i * ld] += p->g;
    }
}

static int damping(double t, const double *q, const double *v, double *D, int ldd, void *user)
{
  const model *p = user;
  (void)t;
  formula(p, 0, p->links, 0, q, v, D, ldd);
  if (p->bad == NOT_A_NUMBER) D[ldd + 2] = NAN;
  return p->bad == CODE ? p->code : 0;
}

static int stiffness(double t, const double *q, const double *v, double *K, int ldk, void *user)
{
  const model *p = user;
  (void)t;
  formula(p, 0, p->links, 1, q, v, K, ldk);
  return 0;
}

/* All blocks of the links that are shown; each link adds its own, so that blocks are repeated. */
static int list(const double *q, const double *v, nsdae_block_list *blocks, model *p, int along_q)
{
  const double nan[SIZE * SIZE] = {NAN};
  int shown = p->shown < p->links ? p->shown : p->links, n = p->first[p->blocks];
  for (int e = -1; e < shown; e++) {
    double X[NV * NV] = {0};
    double g = p->g;
    if (e >= 0) p->g = 0; /* once */
    formula(p, e < 0 ? 0 : e, e < 0 ? 0 : e + 1, along_q, q, v, X, n);
    p->g = g;
    for (int r = 0; r < p->blocks; r++)
      for (int c = 0; c < p->blocks; c++) {
        double value[SIZE * SIZE], any = 0;
        int m = p->sizes[r];
        for (int j = 0; j < p->sizes[c]; j++)
          for (int i = 0; i < m; i++)
            any += fabs(value[i + j * m] = X[p->first[r] + i + (p->first[c] + j) * n]);
        if (any > 0) assert_int_equal(nsdae_block_add(blocks, r, c, value), NSDAE_OK);
      }
  }
  p->listed++;
  if (p->bad == NO_BLOCK)
    assert_int_equal(nsdae_block_add(blocks, 0, p->blocks, nan), NSDAE_E_ARGUMENT);
  if (p->bad == NO_VALUE) assert_int_equal(nsdae_block_add(blocks, 1, 0, NULL), NSDAE_E_ARGUMENT);
  if (p->bad == NOT_A_NUMBER)
    assert_int_equal(nsdae_block_add(blocks, 1, 0, nan), NSDAE_E_NONFINITE);
  return p->bad == CODE ? p->code : 0;
}

static int damping_blocks(double t, const double *q, const double *v, nsdae_block_list *blocks,
                          void *user)
{
  (void)t;
  return list(q, v, blocks, user, 0);
}

static int stiffness_blocks(double t, const double *q, const double *v, nsdae_block_list *blocks,
                            void *user)
{
  (void)t;
  return list(q, v, blocks, user, 1);
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const model *p = user;
  (void)t, (void)q;
  for (int i = 0; i < p->first[p->blocks]; i++) M[i * (ldm + 1)] = p->M[i];
  return 0;
}

static int mass_blocks(double t, const double *q, double *M, void *user)
{
  const model *p = user;
  (void)t, (void)q;
  for (int b = 0; b < p->blocks; M += p->sizes[b] * p->sizes[b], b++)
    for (int i = 0; i < p->sizes[b]; i++) M[i * (p->sizes[b] + 1)] = p->M[p->first[b] + i];
  return 0;
}

/* A row for each link, so that all coupled blocks share one. */
static int constraint(double t, const double *q, double *phi, void *user)
{
  const model *p = user;
  (void)t;
  for (int e = 0; e < p->links; e++) phi[e] = along(p, &p->link[e], q);
  return 0;
}

static int rows(double t, const double *q, nsdae_row_list *list, void *user)
{
  const model *p = user;
  (void)t, (void)q;
  for (int e = 0; e < p->links; e++)
    for (int side = 0; side < 2; side++) {
      const double *w = p->link[e].w[side];
      double row[SIZE];
      for (int i = 0; i < SIZE; i++) row[i] = w[i] + (i > 0 ? w[i - 1] / 3 : 0);
      nsdae_row_add(list, e, p->link[e].block[side], row);
    }
  return 0;
}

/* Of no constraint in particular: the residual takes them as they are. */
static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  const model *p = user;
  (void)t, (void)q, (void)v;
  for (int e = 0; e < p->links; e++) phi_t[e] = 0.5 * e - 3, omega[e] = 7 - 2 * e;
  return 0;
}

/* ---- random systems */

enum shape { CHAIN, RANDOM, STAR };

static void draw(model *p, uint64_t seed, int shape)
{
  random_state r = {seed};
  *p = (model){.blocks = BLOCKS, .shown = LINKS, .fail_at = -1, .g = 2};
  p->links = shape == RANDOM ? LINKS : BLOCKS - 1;
  for (int b = 0; b < BLOCKS; b++) {
    p->sizes[b] = random_int(&r, 1, SIZE);
    p->first[b + 1] = p->first[b] + p->sizes[b];
  }
  for (int i = 0; i < NV; i++) p->M[i] = 1.5 + random_number(&r);
  for (int e = 0; e < p->links; e++) {
    link *l = &p->link[e];
    l->block[1] = shape == STAR ? 0 : shape == CHAIN ? e : random_int(&r, 0, BLOCKS - 1);
    do l->block[0] = shape == RANDOM ? random_int(&r, 0, BLOCKS - 1) : e + 1;
    while (l->block[0] == l->block[1]);
    l->d = 5 + 5 * random_number(&r);
    l->k = 50 + 50 * random_number(&r);
    random_matrix(&r, SIZE, 2, &l->w[0][0], SIZE);
  }
}

typedef struct fixture {
  model p;
  nsdae_system *system;
  nsdae_differences differences;
  nsdae_terms terms;
  nsdae_newton_matrix newton;
  nsdae_error error;
  nsdae_evals evals;
  nsdae_arena arena;
  double q[NV], v[NV];
} fixture;

static void layout(void *object, nsdae_arena *arena)
{
  fixture *f = object;
  nsdae_differences_layout(&f->differences, arena);
  nsdae_terms_layout(&f->terms, arena);
  nsdae_newton_matrix_layout(&f->newton, arena);
}

enum { BY_BLOCKS = 1, DAMPING = 2, STIFFNESS = 4, ROWS = 8, BIAS = 16 };

static int begin(fixture *f, uint64_t seed, int shape, int with)
{
  memset(f, 0, sizeof *f);
  draw(&f->p, seed, shape);
  model *p = &f->p;
  nsdae_dims dims = {.nq = p->first[BLOCKS], .m = with & ROWS ? p->links : 0};
  assert_int_equal(nsdae_system_create(&dims, &f->system, NULL), NSDAE_OK);
  nsdae_system_set_user(f->system, p);
  nsdae_system_set_force(f->system, force);
  nsdae_system_set_kinematics(f->system, kinematics);
  if (with & BY_BLOCKS) {
    nsdae_system_set_blocks(f->system, BLOCKS, p->sizes, p->sizes);
    nsdae_system_set_mass_blocks(f->system, mass_blocks);
    if (with & DAMPING) nsdae_system_set_force_damping_blocks(f->system, damping_blocks);
    if (with & STIFFNESS) nsdae_system_set_force_stiffness_blocks(f->system, stiffness_blocks);
    if (with & ROWS) nsdae_system_set_constraint_rows(f->system, rows);
  } else {
    nsdae_system_set_mass(f->system, mass);
    if (with & DAMPING) nsdae_system_set_force_damping(f->system, damping);
    if (with & STIFFNESS) nsdae_system_set_force_stiffness(f->system, stiffness);
  }
  if (with & ROWS) nsdae_system_set_constraint(f->system, constraint);
  if (with & BIAS) nsdae_system_set_constraint_bias(f->system, bias);
  assert_int_equal(nsdae_system_complete(f->system, &f->error), NSDAE_OK);
  f->differences.system = f->terms.system = f->newton.system = f->system;
  f->terms.differences = &f->differences;
  f->terms.error = &f->error;
  f->terms.evals = &f->evals;
  assert_int_equal(nsdae_arena_build(&f->arena, layout, f), NSDAE_OK);
  random_state r = {seed + 1000};
  for (int i = 0; i < NV; i++) f->q[i] = random_number(&r), f->v[i] = random_number(&r);
  nsdae_terms_at(&f->terms, 0.5, f->q, f->v);
  if (with & BY_BLOCKS && with & ROWS) {
    const nsdae_room none = {0}, room = {2 * LINKS, 2 * LINKS * SIZE};
    assert_int_equal(nsdae_terms_grow(&f->terms, &none, &room), NSDAE_OK);
  }
  return nsdae_newton_matrix_start(&f->newton, &f->terms);
}

static void end(fixture *f)
{
  nsdae_block_pairs_release(&f->newton.pairs);
  nsdae_terms_release(&f->terms);
  nsdae_arena_release(&f->arena);
  nsdae_system_destroy(&f->system);
}

/* Largest |A - formula| of the matrix, over the largest entry. */
static double error_of(const fixture *f, double cj)
{
  const model *p = &f->p;
  const nsdae_newton_matrix *N = &f->newton;
  static double D[NV * NV], K[NV * NV], A[NV * NV];
  int n = p->first[BLOCKS];
  double worst = 0, largest = 0;
  memset(D, 0, sizeof D), memset(K, 0, sizeof K), memset(A, 0, sizeof A);
  formula(p, 0, p->links, 0, f->q, f->v, D, n);
  formula(p, 0, p->links, 1, f->q, f->v, K, n);
  const nsdae_blocks *blocks = &f->system->blocks;
  for (int b = 0; b < blocks->count; b++)
    for (int j = 0, size = nsdae_blocks_size(blocks, b); j < size; j++)
      for (int i = 0; i < size; i++)
        A[blocks->first[b] + i + (blocks->first[b] + j) * n] =
            N->A[blocks->square[b] + (size_t)(i + j * size)];
  const double *value = N->coupling.value;
  for (int e = 0; e < N->coupling.count; e++) {
    int r = N->coupling.pair[2 * e], c = N->coupling.pair[2 * e + 1];
    assert_true(r > c);
    for (int j = blocks->first[c]; j < blocks->first[c + 1]; j++)
      for (int i = blocks->first[r]; i < blocks->first[r + 1]; i++)
        A[i + j * n] = A[j + i * n] = *value++;
  }
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      double exact = (i == j ? p->M[i] : 0) + (D[i + j * n] + D[j + i * n]) / (2 * cj) +
                     (K[i + j * n] + K[j + i * n]) / (2 * cj * cj);
      worst = fmax(worst, fabs(A[i + j * n] - exact));
      largest = fmax(largest, fabs(exact));
    }
  return worst / largest;
}

static const double cjs[] = {1e-3, 0.1, 1, 30, 1e3, 1e5};
enum { CJS = sizeof cjs / sizeof *cjs, SEEDS = 8 };

/* A formula has the roundings of its sums; a difference of step 2^-26 of values F, F' up to 1e3 has
 * eps F / 2^-26 and 2^-26 F'', some 1e-5 of its largest entry. */
static void test_agrees(void **state)
{
  (void)state;
  const struct {
    int with;
    double tol;
  } of[] = {{DAMPING | STIFFNESS, 1e-14},
            {0, 1e-5},
            {DAMPING, 1e-5},
            {STIFFNESS, 1e-5},
            {BY_BLOCKS | DAMPING | STIFFNESS, 1e-14},
            {BY_BLOCKS | DAMPING | STIFFNESS | ROWS, 1e-14},
            {BY_BLOCKS | ROWS, 1e-5},
            {BY_BLOCKS | DAMPING, 1e-5},
            {BY_BLOCKS | STIFFNESS, 1e-5},
            {BY_BLOCKS | STIFFNESS | ROWS, 1e-5}};
  for (size_t c = 0; c < sizeof of / sizeof *of; c++)
    for (uint64_t seed = 0; seed < SEEDS; seed++)
      for (int shape = CHAIN; shape <= STAR; shape++) {
        fixture f;
        assert_int_equal(begin(&f, seed, shape, of[c].with), NSDAE_OK);
        for (int i = 0; i < CJS; i++) {
          allocator_reset(-1);
          assert_int_equal(nsdae_terms_newton_matrix(&f.terms, cjs[i], &f.newton), NSDAE_OK);
          assert_int_equal(the_allocator.calls, 0);
          assert_int_equal(f.newton.pairs.missed, 0);
          assert_at_most(error_of(&f, cjs[i]), of[c].tol);
        }
        end(&f);
      }
}

/* r_q = q' - H v and q* = q - r_q / cj; at q* r_v = M v' + Phi_q^T lambda - F and r_lambda = Phi_q
 * v'
 * + omega + 2 alpha (Phi_q v + phi_t) + beta^2 Phi. */
static void test_residual(void **state)
{
  (void)state;
  const double cj = 30, alpha = 3, beta = 5;
  for (uint64_t seed = 0; seed < SEEDS; seed++) {
    fixture f;
    double y[2 * NV + LINKS], ydot[2 * NV], room[2 * NV], r[2 * NV + LINKS], H_v[NV], H_a[NV];
    assert_int_equal(begin(&f, seed, RANDOM, BY_BLOCKS | ROWS | BIAS), NSDAE_OK);
    model *p = &f.p;
    int n = p->first[BLOCKS];
    random_state draws = {seed + 2000};
    for (int i = 0; i < 2 * n + LINKS; i++) y[i] = random_number(&draws);
    for (int i = 0; i < 2 * n; i++) ydot[i] = random_number(&draws);
    kinematics(0, y, y + n, H_v, p);
    kinematics(0, y, ydot + n, H_a, p);
    assert_int_equal(nsdae_newton_kkt_move(&f.terms, 0.5, y, ydot, cj, room, r), NSDAE_OK);
    for (int i = 0; i < n; i++) {
      assert_near(r[i], ydot[i] - H_v[i], 1e-14);
      assert_near(room[i], y[i] - (ydot[i] - H_v[i]) / cj, 1e-14);
      assert_true(room[n + i] == y[n + i]);
    }
    nsdae_terms_at(&f.terms, 0.5, room, room + n);
    assert_int_equal(nsdae_terms_need(&f.terms, NSDAE_TERM_MASS | NSDAE_TERM_FORCE |
                                                    NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                                                    NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA),
                     NSDAE_OK);
    nsdae_newton_kkt_residual(&f.terms, alpha, beta, y, ydot, r);
    double wanted[2 * NV + LINKS] = {0}, F[NV] = {0}, *of = wanted + 2 * n;
    force(0, room, y + n, F, p);
    for (int i = 0; i < n; i++) wanted[n + i] = p->M[i] * ydot[n + i] - F[i];
    for (int e = 0; e < p->links; e++) {
      const link *l = &p->link[e];
      of[e] = along(p, l, H_a) + 7 - 2 * e + 2 * alpha * (along(p, l, H_v) + 0.5 * e - 3) +
              beta * beta * along(p, l, room);
      for (int side = 0; side < 2; side++)
        for (int j = 0; j < p->sizes[l->block[side]]; j++)
          wanted[n + p->first[l->block[side]] + j] +=
              y[2 * n + e] * (l->w[side][j] + (j > 0 ? l->w[side][j - 1] / 3 : 0));
    }
    /* forces up to 1e3, in sums of some hundred terms */
    for (int i = n; i < 2 * n + p->links; i++) assert_near(r[i], wanted[i], 1e-11);
    end(&f);
  }
}

/* A chain has three colours, whatever its length; one displacement of each velocity then gives D
 * and K together. */
static void test_evaluations(void **state)
{
  (void)state;
  fixture f;
  assert_int_equal(begin(&f, 3, CHAIN, BY_BLOCKS | ROWS), NSDAE_OK);
  assert_int_equal(nsdae_terms_need(&f.terms, NSDAE_TERM_FORCE), NSDAE_OK);
  f.evals.force = f.p.forces = 0;
  assert_int_equal(nsdae_terms_newton_matrix(&f.terms, 100, &f.newton), NSDAE_OK);
  assert_int_equal(f.newton.colours, 3);
  assert_true(f.p.forces > 0 && f.p.forces <= 3 * SIZE);
  assert_int_equal(f.evals.force, f.p.forces);
  end(&f);
  assert_int_equal(begin(&f, 3, CHAIN, BY_BLOCKS | DAMPING | STIFFNESS), NSDAE_OK);
  assert_int_equal(nsdae_terms_newton_matrix(&f.terms, 100, &f.newton), NSDAE_OK);
  assert_int_equal(f.p.forces, 0);
  end(&f);
}

/* A callback that couples more blocks later: left out, counted, there after the growth. */
static void test_growth(void **state)
{
  (void)state;
  fixture f;
  assert_int_equal(begin(&f, 5, RANDOM, BY_BLOCKS | DAMPING | STIFFNESS), NSDAE_OK);
  end(&f);
  for (int shown = 0; shown < LINKS; shown += 5) {
    memset(&f, 0, sizeof f);
    assert_int_equal(begin(&f, 5, RANDOM, BY_BLOCKS | DAMPING | STIFFNESS), NSDAE_OK);
    nsdae_block_pairs_release(&f.newton.pairs);
    f.p.shown = shown;
    assert_int_equal(nsdae_newton_matrix_start(&f.newton, &f.terms), NSDAE_OK);
    int before = f.newton.coupling.count, rounds = 0;
    f.p.shown = LINKS;
    for (;; rounds++) {
      allocator_reset(-1);
      assert_int_equal(nsdae_terms_newton_matrix(&f.terms, 1, &f.newton), NSDAE_OK);
      assert_int_equal(the_allocator.calls, 0);
      if (f.newton.pairs.missed == 0) break;
      assert_true(error_of(&f, 1) > 1e-6);
      assert_int_equal(nsdae_newton_matrix_grow(&f.newton), NSDAE_OK);
    }
    assert_in_range(rounds, 1, 2);
    assert_true(f.newton.coupling.count > before);
    assert_at_most(error_of(&f, 1), 1e-14);
    end(&f);
  }
}

/* Every allocation of start and growth fails in turn: the status, and nothing is leaked. */
static void test_memory(void **state)
{
  (void)state;
  for (int with = 0; with < 16; with++) {
    if ((with & ROWS) && !(with & BY_BLOCKS)) continue;
    fixture f;
    int status = NSDAE_E_MEMORY;
    for (long at = 0; status != NSDAE_OK; at++) {
      assert_int_equal(begin(&f, 2, RANDOM, with), NSDAE_OK);
      nsdae_block_pairs_release(&f.newton.pairs);
      allocator_reset(at);
      status = nsdae_newton_matrix_start(&f.newton, &f.terms);
      allocator_reset(-1);
      if (status != NSDAE_OK) assert_int_equal(status, NSDAE_E_MEMORY);
      if (status != NSDAE_OK) assert_int_equal(f.error.status, NSDAE_E_MEMORY);
      end(&f);
      assert_true(at < 60);
    }
  }
}

static void test_failures(void **state)
{
  (void)state;
  const struct {
    int bad, code, status;
    const char *argument;
  } of[] = {{NO_BLOCK, 0, NSDAE_E_ARGUMENT, "column"},
            {NO_VALUE, 0, NSDAE_E_ARGUMENT, "value"},
            {NOT_A_NUMBER, 0, NSDAE_E_NONFINITE, "value"},
            {CODE, 7, NSDAE_E_CALLBACK, "force_damping_blocks"},
            {CODE, -7, NSDAE_E_CALLBACK, "force_damping_blocks"}};
  fixture f;
  for (size_t c = 0; c < sizeof of / sizeof *of; c++) {
    assert_int_equal(begin(&f, 1, CHAIN, BY_BLOCKS | DAMPING), NSDAE_OK);
    f.p.bad = of[c].bad, f.p.code = of[c].code;
    assert_int_equal(nsdae_terms_newton_matrix(&f.terms, 10, &f.newton), of[c].status);
    assert_int_equal(f.error.status, of[c].status);
    assert_string_equal(f.error.argument, of[c].argument);
    assert_non_null(strstr(f.error.text, "force_damping_blocks"));
    assert_true(f.error.time == 0.5);
    assert_int_equal(f.error.code, of[c].code);
    f.p.bad = 0;
    assert_int_equal(nsdae_terms_newton_matrix(&f.terms, 10, &f.newton), NSDAE_OK);
    assert_at_most(error_of(&f, 10), 1e-5);
    end(&f);
  }
  for (int bad = NOT_A_NUMBER; bad <= CODE; bad++) {
    assert_int_equal(begin(&f, 1, CHAIN, DAMPING), NSDAE_OK);
    f.p.bad = bad, f.p.code = 3;
    int status = nsdae_terms_newton_matrix(&f.terms, 10, &f.newton);
    assert_int_equal(status, bad == CODE ? NSDAE_E_CALLBACK : NSDAE_E_NONFINITE);
    assert_string_equal(f.error.argument, "force_damping");
    assert_true(f.error.time == 0.5);
    if (bad == NOT_A_NUMBER) assert_non_null(strstr(f.error.text, "velocity 2"));
    end(&f);
  }
  /* ---- F fails in a difference */
  assert_int_equal(begin(&f, 1, CHAIN, BY_BLOCKS | ROWS), NSDAE_OK);
  for (f.p.fail_at = 0; f.p.fail_at < 3 * SIZE; f.p.fail_at++) {
    f.p.forces = 0, f.p.code = 2;
    nsdae_terms_at(&f.terms, 0.5, f.q, f.v);
    int status = nsdae_terms_newton_matrix(&f.terms, 10, &f.newton);
    if (f.p.forces <= f.p.fail_at) break;
    assert_int_equal(status, NSDAE_E_CALLBACK);
    assert_string_equal(f.error.argument, "force");
    assert_int_equal(f.error.code, 2);
  }
  assert_true(f.p.fail_at > 3);
  end(&f);
  assert_int_equal(nsdae_block_add(NULL, 0, 0, NULL), NSDAE_E_ARGUMENT);
}

/* nsdae_system_check: right ones pass, a wrong entry is named, a list that is refused also. */
static void test_check(void **state)
{
  (void)state;
  for (int blocks = 0; blocks < 2; blocks++) {
    fixture f;
    nsdae_check worst;
    assert_int_equal(begin(&f, 4, RANDOM, blocks | DAMPING | STIFFNESS), NSDAE_OK);
    assert_int_equal(nsdae_system_check(f.system, 0.5, f.q, f.v, 1e-5, &worst), NSDAE_OK);
    assert_at_most(worst.error, 1e-6); /* 1e-10 of F ~ 1e3 */
    if (blocks) {
      f.p.shown = 3;
      assert_int_equal(nsdae_system_check(f.system, 0.5, f.q, f.v, 1e-5, &worst),
                       NSDAE_E_DERIVATIVE);
      assert_non_null(strstr(worst.term, "_blocks"));
      assert_non_null(strstr(nsdae_system_error(f.system)->text, "velocity"));
    }
    f.p.bad = NOT_A_NUMBER;
    assert_int_equal(nsdae_system_check(f.system, 0.5, f.q, f.v, 1e-5, NULL),
                     blocks ? NSDAE_E_NONFINITE : NSDAE_E_DERIVATIVE);
    assert_non_null(strstr(nsdae_system_error(f.system)->text, "force_damping"));
    end(&f);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_agrees),      cmocka_unit_test(test_residual),
      cmocka_unit_test(test_evaluations), cmocka_unit_test(test_growth),
      cmocka_unit_test(test_memory),      cmocka_unit_test(test_failures),
      cmocka_unit_test(test_check),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
