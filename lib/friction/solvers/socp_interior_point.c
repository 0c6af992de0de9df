/* A primal-dual interior point for  b = W r + q + s e_N in K*,  r in K,  b . r = 0  (Mehrotra, SIAM
 * J. Optim. 2 (1992) 575; of second-order cones with the scaling of Nesterov and Todd: Andersen,
 * Roos, Terlaky, Math. Program. 95 (2003) 249; written as in Vandenberghe, "The CVXOPT linear and
 * quadratic cone program solvers", 2010). In rows scaled by S (map.h) a = S r and b = S^-1 (u + s
 * e_N) are both in the second-order cone, and W with W a = W^-1 b makes a step
 *
 *   db + W^2 da = -b + sigma a^-1 - W (W a \ (W^-1 db o W da)),   db = S^-1 (W' S^-1 da + gap)
 *
 * where o is the product of that cone's algebra, \ its division, and the last term is that of the
 * step without it. Divided by 1 + W^2 the equations are those of the smoothed map, with G = 1 / (1
 * + W^2): of what is as large as rounding in one of them the other one has all digits. That is why
 * db is of the one where W is large, and of the other where it is small: complementarity goes down
 * to 1e-12 and below, where impulses are 1e4. */
#include <math.h>
#include <string.h>

#include "cone.h"
#include "solver_contract.h"

/* Steps in which the mean of a . b has to be halved: short ones near the edge of the cone, and
 * those that rounding rules, end there. Of 72 seeded problems 10 leave 2 above 1e-6, 20 leave 5. */
enum { IDLE = 10 };

/* Share of the way to the edge of the cone, as usual (Andersen, Roos, Terlaky 2003); the mean of a
 * . b of a solution, whose residual is its root, 1e-3: s is no nearer when the fixed point begins.
 */
static const double SHARE = 0.99, SOLVED = 1e-6;

/* a o b of the first point, its root: of a warm start, and of cold ones. Warm ones further inside
 * break down earlier, at a residual of 1e-5, where r = 0 at 1e2 goes on to 2e-6. */
static const double WARM = 1, COLD[] = {1e2, 1e4};

void nsdae_fc_socp_layout(nsdae_fc_socp *p, const nsdae_fc_scaled *fc, nsdae_arena *arena)
{
  long n = fc->n;
  p->s = NSDAE_ARENA_DOUBLES(arena, n);
  p->axis = NSDAE_ARENA_DOUBLES(arena, 2 * n);
  nsdae_arena_doubles(
      arena, 3 * n,
      (double **[]){&p->a, &p->b, &p->da, &p->db, &p->rhs, &p->root, &p->gap, &p->end, NULL});
}

/* Rows of item k, the others being zero: three of a cone, else one. */
static int rows_of(const nsdae_fc_scaled *c, int k)
{
  return c->items.kind[k] == NSDAE_FC_CONE ? 3 : 1;
}

static int bilateral(const nsdae_fc_scaled *c, int k)
{
  return c->items.kind[k] == NSDAE_FC_BILATERAL;
}

static void scale_of(const nsdae_fc_scaled *c, int k, double S[3])
{
  S[0] = rows_of(c, k) == 3 ? sqrt(c->items.mu[k]) : 1;
  S[1] = S[2] = 1 / S[0];
}

/* r of item k with its base, rounded. */
static void impulse(const nsdae_fc_scaled *c, int k, double x[3])
{
  double low[3] = {0};
  memcpy(x, c->r + 3 * k, 3 * sizeof *x);
  if (c->base.high) nsdae_fc_impulse(c, k, c->r, x, low);
  for (int i = 0; i < 3; i++) x[i] = i < rows_of(c, k) ? x[i] + low[i] : 0;
}

/* b of item k as the velocities u [3] have it. */
static void dual(const nsdae_fc_socp *p, const nsdae_fc_scaled *c, int k, const double *u,
                 double b[3])
{
  double S[3];
  scale_of(c, k, S);
  b[0] = (u[0] + (rows_of(c, k) == 3 ? p->s[k] : 0)) / S[0];
  for (int i = 1; i < 3; i++) b[i] = rows_of(c, k) == 3 ? u[i] / S[i] : 0;
}

/* ---- Jordan algebra of the second-order cone */

static double product(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* x_N^2 - |x_T|^2 */
static double determinant(const double *x)
{
  double t = nsdae_fc_length(x[1], x[2]);
  return (x[0] - t) * (x[0] + t);
}

/* y := F x, F with eigenvalues f along (1, d), (1, -d) and across them */
static void apply(const double f[3], const double d[2], const double *x, double *y)
{
  double along = d[0] * x[1] + d[1] * x[2], across = f[2] * (d[0] * x[2] - d[1] * x[1]);
  double high = f[0] * (x[0] + along) / 2, low = f[1] * (x[0] - along) / 2;
  y[0] = high + low;
  y[1] = (high - low) * d[0] - across * d[1];
  y[2] = (high - low) * d[1] + across * d[0];
}

/* a and b with a - b = z and a o b = e^2, for each eigenvalue of z. */
static void spectral_decomposition(double e, const double z[3], double *a, double *b)
{
  double t = nsdae_fc_length(z[1], z[2]), d[2] = {t > 0 ? z[1] / t : 1, t > 0 ? z[2] / t : 0};
  double A[2], B[2];
  for (int i = 0; i < 2; i++) {
    double l = i == 0 ? z[0] + t : z[0] - t, large = (fabs(l) + sqrt(l * l + 4 * e * e)) / 2;
    A[i] = l > 0 ? large : e * e / large;
    B[i] = l > 0 ? e * e / large : large;
  }
  a[0] = (A[0] + A[1]) / 2;
  b[0] = (B[0] + B[1]) / 2;
  for (int i = 0; i < 2; i++) {
    a[i + 1] = (A[0] - A[1]) / 2 * d[i];
    b[i + 1] = (B[0] - B[1]) / 2 * d[i];
  }
}

/* ---- a point */

/* A point inside both cones, at fc->r and its velocities. */
static void begin_interior(nsdae_fc_socp *p, nsdae_fc_scaled *c, double e)
{
  memset(p->da, 0, 3 * (size_t)c->n * sizeof *p->da);
  memset(p->db, 0, 3 * (size_t)c->n * sizeof *p->db);
  for (int k = 0; k < c->n; k++) {
    double S[3], z[3], *a = p->a + 3 * k, *b = p->b + 3 * k;
    scale_of(c, k, S);
    dual(p, c, k, c->u + 3 * k, b);
    impulse(c, k, a);
    for (int i = 0; i < 3; i++) {
      a[i] *= S[i];
      z[i] = a[i] - b[i];
    }
    if (bilateral(c, k)) {
      memset(b, 0, 3 * sizeof *b);
      continue;
    }
    double before[3] = {a[0], a[1], a[2]};
    spectral_decomposition(e, z, a, b);
    for (int i = 0; i < 3; i++) c->r[3 * k + i] += (a[i] - before[i]) / S[i];
  }
}

/* The velocities of fc->r, and what b lacks of them. */
static void evaluate_gap(nsdae_fc_socp *p, nsdae_fc_scaled *c)
{
  nsdae_fc_velocities(c, c->r, c->y, c->u);
  for (int k = 0; k < c->n; k++) {
    double S[3], b[3];
    scale_of(c, k, S);
    dual(p, c, k, c->u + 3 * k, b);
    for (int i = 0; i < 3; i++) p->gap[3 * k + i] = S[i] * (b[i] - p->b[3 * k + i]);
  }
}

/* The mean of a . b after a step of this length. */
static double mean(const nsdae_fc_socp *p, const nsdae_fc_scaled *c, double length)
{
  double sum = 0;
  int count = 0;
  for (int k = 0; k < c->n; k++) {
    if (bilateral(c, k)) continue;
    for (int i = 3 * k; i < 3 * k + 3; i++)
      sum += (p->a[i] + length * p->da[i]) * (p->b[i] + length * p->db[i]);
    count++;
  }
  return count > 0 ? sum / count : 0;
}

/* ---- Newton matrix */

/* W of item k: with a and b over the roots of their determinants and w = (b + J a) / (2 g), g =
 * sqrt((1 + a . b) / 2), J = (1, -1, -1), it is beta (2 v v^T - J) with v o v = w, and has these
 * eigenvalues. Returns 0 where the point is not inside. */
static int nesterov_todd(nsdae_fc_socp *p, int k)
{
  const double *a = p->a + 3 * k, *b = p->b + 3 * k;
  double *root = p->root + 3 * k, *d = p->axis + 2 * k;
  double det_a = sqrt(determinant(a)), det_b = sqrt(determinant(b));
  if (!(det_a > 0 && det_b > 0)) return 0;
  double g = 2 * sqrt((1 + product(a, b) / (det_a * det_b)) / 2), beta = sqrt(det_b / det_a);
  double w[3] = {(b[0] / det_b + a[0] / det_a) / g, (b[1] / det_b - a[1] / det_a) / g,
                 (b[2] / det_b - a[2] / det_a) / g};
  double t = nsdae_fc_length(w[1], w[2]);
  d[0] = t > 0 ? w[1] / t : 1;
  d[1] = t > 0 ? w[2] / t : 0;
  root[0] = beta * (w[0] + t);
  root[1] = beta / (w[0] + t);
  root[2] = beta;
  return 1;
}

/* E and A of an item, of its rows. */
static void fill(nsdae_fc_newton *s, int k, const double *root, const double *d)
{
  const nsdae_fc_scaled *c = s->fc;
  double *E = s->E + 9 * (size_t)k, *A = s->A + 9 * (size_t)k, S[3], G[3], H[3], g[3], h[3];
  const int rows = rows_of(c, k);
  scale_of(c, k, S);
  for (int i = 0; i < 3; i++) {
    double square = bilateral(c, k) ? 0 : root[i] * root[i];
    G[i] = 1 / (1 + square);
    H[i] = square / (1 + square);
  }
  for (int j = 0; j < 3; j++) {
    const double one[3] = {j == 0, j == 1, j == 2};
    apply(G, d, one, g);
    apply(H, d, one, h);
    for (int i = 0; i < 3; i++) {
      A[3 * i + j] = i < rows && j < rows ? g[i] / S[j] : 0;
      E[3 * i + j] = i < rows && j < rows
                         ? h[i] * S[j] + A[3 * i + j] * (NSDAE_FC_REGULAR + c->items.C[3 * k + j])
                         : i == j;
    }
  }
}

/* ---- directions */

/* What db + W^2 da is to be, with the second order W (W a \ (W^-1 db o W da)) of the step at hand
 * or without. */
static void set_rhs(nsdae_fc_socp *p, int k, double sigma, int corrected)
{
  const double *a = p->a + 3 * k, *b = p->b + 3 * k, share = sigma / determinant(a);
  const double *root = p->root + 3 * k, *d = p->axis + 2 * k;
  double *rhs = p->rhs + 3 * k;
  for (int i = 0; i < 3; i++) rhs[i] = (i == 0 ? share : -share) * a[i] - b[i];
  if (!corrected) return;
  double inverse[3] = {1 / root[0], 1 / root[1], 1 / root[2]}, l[3], v[3], w[3], m[3], z[3], x[3];
  apply(inverse, d, p->db + 3 * k, v);
  apply(root, d, p->da + 3 * k, w);
  apply(root, d, a, l);
  m[0] = product(v, w);
  for (int i = 1; i < 3; i++) m[i] = v[0] * w[i] + w[0] * v[i];
  z[0] = (l[0] * m[0] - l[1] * m[1] - l[2] * m[2]) / determinant(l);
  for (int i = 1; i < 3; i++) z[i] = (m[i] - l[i] * z[0]) / l[0];
  apply(root, d, z, x);
  for (int i = 0; i < 3; i++) rhs[i] -= x[i];
}

/* db of item k: of its equation where W is small, else of the velocities u after the step. */
static void dual_step(nsdae_fc_socp *p, const nsdae_fc_scaled *c, int k, const double *u)
{
  const double *root = p->root + 3 * k, *d = p->axis + 2 * k;
  double square[3], small[3], large[3], x[3], y[3], *db = p->db + 3 * k;
  for (int i = 0; i < 3; i++) {
    square[i] = root[i] * root[i];
    small[i] = square[i] < 1;
    large[i] = !(square[i] < 1);
  }
  dual(p, c, k, u, y);
  for (int i = 0; i < 3; i++) y[i] -= p->b[3 * k + i];
  apply(large, d, y, db);
  apply(square, d, p->da + 3 * k, x);
  for (int i = 0; i < 3; i++) x[i] = p->rhs[3 * k + i] - x[i];
  apply(small, d, x, y);
  for (int i = 0; i < 3; i++) db[i] += y[i];
}

/* A step. */
static void newton_direction(nsdae_fc_socp *p, nsdae_fc_newton *s, double sigma, int corrected)
{
  const nsdae_fc_scaled *c = s->fc;
  double S[3];
  for (int k = 0; k < c->n; k++) {
    const double *A = s->A + 9 * (size_t)k;
    scale_of(c, k, S);
    memset(s->F + 3 * k, 0, 3 * sizeof *s->F);
    if (bilateral(c, k))
      memset(p->rhs + 3 * k, 0, 3 * sizeof *p->rhs);
    else
      set_rhs(p, k, sigma, corrected);
    for (int i = 0; i < 9; i++)
      s->F[3 * k + i / 3] += A[i] * (S[i % 3] * p->rhs[3 * k + i % 3] - p->gap[3 * k + i % 3]);
  }
  nsdae_fc_newton_solve(s, s->F, s->dr);
  for (int i = 0; i < 3 * c->n; i++) s->trial[i] = c->r[i] + s->dr[i];
  nsdae_fc_velocities(c, s->trial, s->y, s->u);
  for (int k = 0; k < c->n; k++) {
    scale_of(c, k, S);
    for (int i = 0; i < 3; i++) p->da[3 * k + i] = S[i] * s->dr[3 * k + i];
    if (bilateral(c, k))
      memset(p->db + 3 * k, 0, 3 * sizeof *p->db);
    else
      dual_step(p, c, k, s->u + 3 * k);
  }
}

/* ---- steps */

/* How far it is from x along dx to the edge of the cone: the least root of  dx^2 t^2 + 2 (x . dx) t
 * + x^2, squares and products with J. */
static double step_to_boundary(const double *x, const double *dx)
{
  double A = determinant(dx), B = x[0] * dx[0] - x[1] * dx[1] - x[2] * dx[2], C = determinant(x);
  double root = sqrt(fmax(0, B * B - A * C)), apex = dx[0] < 0 ? -x[0] / dx[0] : INFINITY;
  if (B < 0 && B * B >= A * C) return fmin(apex, C / (root - B));
  return A < 0 ? fmin(apex, (B + root) / -A) : apex;
}

/* The longest step that stays inside, at most 1. */
static double longest(const nsdae_fc_socp *p, const nsdae_fc_scaled *c, double share)
{
  double length = 1;
  for (int k = 0; k < c->n; k++) {
    if (bilateral(c, k)) continue;
    length = fmin(length, share * step_to_boundary(p->a + 3 * k, p->da + 3 * k));
    length = fmin(length, share * step_to_boundary(p->b + 3 * k, p->db + 3 * k));
  }
  return length;
}

/* Predictor and corrector; the length of the step, 0 where there is none. */
static double predictor_corrector(nsdae_fc_socp *p, nsdae_fc_newton *s, double now)
{
  nsdae_fc_scaled *c = s->fc;
  for (int k = 0; k < c->n; k++) { /* the matrix at the point */
    if (bilateral(c, k))
      p->axis[2 * k] = 1, p->axis[2 * k + 1] = 0;
    else if (!nesterov_todd(p, k))
      return 0;
    fill(s, k, p->root + 3 * k, p->axis + 2 * k);
  }
  if (nsdae_fc_system_factor(s->system, s->E, s->A) != 0) return 0;
  newton_direction(p, s, 0, 0);
  double ratio = mean(p, c, longest(p, c, 1)) / now;
  double sigma = fmin(1, fmax(0, ratio * ratio * ratio));
  newton_direction(p, s, sigma * now, 1);
  double length = longest(p, c, SHARE);
  if (!(length > 0)) return 0;
  for (int i = 0; i < 3 * c->n; i++) {
    c->r[i] += length * s->dr[i];
    p->a[i] += length * p->da[i];
    p->b[i] += length * p->db[i];
  }
  return length;
}

/* ---- the method */

/* From a point at fc.r, a o b of the first point being e^2. On the central path the residual is
 * about the root of the mean of a . b. */
static int run_from(nsdae_fc_island *all, nsdae_fc_iterate *it, const nsdae_fc_budget *budget,
                    double e)
{
  nsdae_fc_socp *p = &all->socp;
  nsdae_fc_scaled *c = &all->fc;
  const double last = 1e-2 * budget->tol * budget->tol;
  nsdae_fc_velocities(c, c->r, c->y, c->u);
  begin_interior(p, c, e);
  evaluate_gap(p, c);
  double now = mean(p, c, 0), least = INFINITY;
  for (int idle = 0; idle < IDLE && now > last && nsdae_fc_spend_step(all, it, budget); idle++) {
    if (!(predictor_corrector(p, &all->newton, now) > 0)) break;
    evaluate_gap(p, c);
    now = mean(p, c, 0);
    if (now < 0.5 * least) least = now, idle = -1;
  }
  return now < SOLVED;
}

int nsdae_fc_socp_run(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  int found = run_from(s, it, b, WARM);
  for (size_t k = 0; k < sizeof COLD / sizeof *COLD && !found; k++) {
    if (!nsdae_fc_spend(s, it, b, 0)) return 0;
    memset(s->fc.r, 0, nsdae_fc_bytes(s));
    found = run_from(s, it, b, COLD[k]);
  }
  memcpy(s->socp.end, s->fc.r, nsdae_fc_bytes(s));
  nsdae_fc_set_point(s, s->fc.r);
  return found;
}

/* s of the iterate, or zero if that is not near a solution, into socp.s; fc.r: the iterate. */
static void socp_begin(nsdae_fc_island *s, const nsdae_fc_iterate *it)
{
  nsdae_fc_set_point(s, it->r);
  for (int k = 0; k < s->fc.n; k++)
    s->socp.s[k] = it->residual < NSDAE_FC_NEAR ? nsdae_fc_s_of(&s->fc, k) : 0;
}

int nsdae_fc_socp_interior_point(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  if (!nsdae_fc_system_ready(s)) return NSDAE_FC_NO_MEMORY;
  socp_begin(s, it);
  nsdae_fc_socp_run(s, it, b);
  nsdae_fc_offer(s, it);
  return it->residual <= b->tol;
}

/* Fixed point on s = mu |u_T| (Acary, Cadoux, Lemarechal, Malick, ZAMM 91 (2011) 155; De Saxce and
 * Feng 1998): with s fixed the problem is a convex second-order cone problem, whose solution by an
 * interior point has the next s. Steps of s are extrapolated by Anderson's method. Each time the
 * residual has fallen, semismooth Newton is tried. */

/* Progress is a reduction by this factor: of the error of s, which FRUITLESS convex problems in a
 * row may lack, and of the residual since Newton's method was tried last. With 0.5, 0.7 and 0.85 of
 * 40 seeded problems 39 are solved to 1e-8; with 6, 12 and 24 in a row 39, 39 and 40. */
static const double PROGRESS = 0.7;
enum { FRUITLESS = 12 };

int nsdae_fc_aclm(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  double tried = INFINITY, least = INFINITY;
  if (!nsdae_fc_system_ready(s)) return NSDAE_FC_NO_MEMORY;
  socp_begin(s, it);
  nsdae_fc_anderson_begin(&s->anderson);
  for (int since = 0; since < FRUITLESS && nsdae_fc_socp_run(s, it, b); since++) {
    double residual = nsdae_fc_offer(s, it), error = 0;
    if (residual <= b->tol) return 1;
    for (int k = 0; k < s->fc.n; k++) {
      double by = nsdae_fc_s_of(&s->fc, k) - s->socp.s[k];
      error += by * by;
    }
    error = sqrt(error); /* |mu |u_T| - s| */
    if (error < PROGRESS * least) least = error, since = -1;
    if (residual < PROGRESS * tried) {
      tried = residual;
      if (nsdae_fc_proximal_points(s, it, b) <= b->tol) return 1;
      nsdae_fc_set_point(s, s->socp.end);
    }
    /* The next s, extrapolated; the rows of normal impulses take its place for the time. Back at
     * the solution of the convex problem then. */
    memset(s->anderson.before, 0, nsdae_fc_bytes(s));
    memset(s->fc.r, 0, nsdae_fc_bytes(s));
    for (int k = 0; k < s->fc.n; k++) {
      s->anderson.before[3 * k] = s->socp.s[k];
      s->fc.r[3 * k] = nsdae_fc_s_of(&s->fc, k);
    }
    nsdae_fc_anderson_collect(&s->anderson, &s->fc);
    nsdae_fc_anderson_extrapolate(&s->anderson, &s->fc);
    for (int k = 0; k < s->fc.n; k++) s->socp.s[k] = fmax(0, s->fc.r[3 * k]);
    nsdae_fc_set_point(s, s->socp.end);
  }
  return it->residual <= b->tol;
}
