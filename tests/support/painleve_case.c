/* The accelerations of contacts, a = G F + b, mode by mode: of each that touches
 *
 *   open:     F_N = 0, a_N >= 0
 *   sliding:  a_N = 0, F_N >= 0, F_T = -mu F_N d with the direction d of sliding, if it is known;
 *             in the plane also d = 1, d = -1 where it is not, with d a_T >= 0
 *   sticking: a_N = 0, a_T = 0, |F_T| <= mu F_N
 *
 * in the plane. In space what rests is asked for less, that a_N = 0 and that the force is in the
 * cone, so that where that has no solution there is none. All modes of all contacts are tried, each
 * a problem of linear inequalities for the parts of F along the edges of the cones: Phase 1 of the
 * simplex method, by Bland's rule (Chvatal, "Linear Programming", 1983, chapters 3 and 8). */
#include "painleve_case.h"

#include <math.h>
#include <string.h>

enum { MOST = 8, ROWS = 44, EDGES = 16, COLUMNS = MOST * EDGES + 2 * ROWS, PIVOTS = 2000 };

static const double MANY = 100, NONE = 1e-9;

/* ---- x >= 0 with A x = f ---- */

typedef struct linear {
  int rows, columns;
  double A[ROWS][COLUMNS + 1]; /* the last: f */
} linear;

static void pivot(linear *p, int basis[], int row, int column, double *cost)
{
  double by = p->A[row][column];
  for (int j = 0; j <= p->columns; j++) p->A[row][j] /= by;
  for (int i = 0; i <= p->rows; i++) {
    double *to = i < p->rows ? p->A[i] : cost, times = to[column];
    for (int j = 0; j <= p->columns && i != row; j++) to[j] -= times * p->A[row][j];
  }
  basis[row] = column;
}

/* The row that bounds the column; -1: none does. */
static int leaving(const linear *p, const int basis[], int column)
{
  int row = -1;
  double least = INFINITY;
  for (int i = 0; i < p->rows; i++) {
    if (!(p->A[i][column] > NONE)) continue;
    double ratio = p->A[i][p->columns] / p->A[i][column];
    if (ratio < least - 1e-14 || (row >= 0 && ratio <= least + 1e-14 && basis[i] < basis[row]))
      row = i, least = fmin(ratio, least);
  }
  return row;
}

/* Rows have the size 1, and an artificial variable each, whose sum is brought down to zero. x
 * [columns] may be NULL. */
static int is_solvable(linear *p, double *x)
{
  double cost[COLUMNS + 1] = {0};
  int basis[ROWS];
  for (int i = 0; i < p->rows; i++) {
    double size = 0, sign = p->A[i][p->columns] < 0 ? -1 : 1;
    for (int j = 0; j <= p->columns; j++) size = fmax(size, fabs(p->A[i][j]));
    for (int j = 0; j <= p->columns && size > 0; j++) {
      p->A[i][j] *= sign / size;
      cost[j] -= p->A[i][j];
    }
    basis[i] = p->columns + i;
  }
  for (int round = 0; round < PIVOTS && -cost[p->columns] > NONE; round++) {
    int column = 0;
    while (column < p->columns && !(cost[column] < -NONE)) column++;
    int row = column < p->columns ? leaving(p, basis, column) : -1;
    if (row < 0) return 0;
    pivot(p, basis, row, column, cost);
  }
  for (int j = 0; x && j < p->columns; j++) x[j] = 0;
  for (int i = 0; x && i < p->rows; i++)
    if (basis[i] < p->columns) x[basis[i]] = p->A[i][p->columns];
  return -cost[p->columns] <= NONE;
}

/* ---- complementarity: y = A x + b, x >= 0, y >= 0, x y = 0 ---- */

typedef struct search {
  const nsdae_lcp_problem *of;
  int zero[ROWS]; /* 1: x_i is zero, 2: y_i, 0: not decided */
  int strict;     /* the other one of it is above `least`; -1: none */
  double least;
  int nodes;
} search;

enum { NODES = 20000 };

/* Without the complements that are not decided: x [n], then y [n]. */
static int relax(const search *s, double *xy)
{
  static linear p; /* large */
  const nsdae_lcp_problem *of = s->of;
  int n = of->n, strict = s->strict >= 0;
  memset(&p, 0, sizeof p);
  p.rows = n + strict;
  p.columns = 2 * n + strict;
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++) p.A[i][j] = s->zero[j] == 1 ? 0 : of->A[j * of->lda + i];
    p.A[i][n + i] = s->zero[i] == 2 ? 0 : -1;
    p.A[i][p.columns] = -of->b[i];
  }
  if (strict) {
    p.A[n][s->strict + (s->zero[s->strict] == 1 ? n : 0)] = 1;
    p.A[n][2 * n] = -1;
    p.A[n][p.columns] = s->least;
  }
  return is_solvable(&p, xy);
}

/* Whether it has a solution, by its two halves wherever a complement is not met. */
static int has_solution(search *s)
{
  double xy[COLUMNS + 1], worst = 1e-9;
  int n = s->of->n, at = -1, any = 0;
  if (s->nodes++ > NODES || !relax(s, xy)) return s->nodes > NODES;
  for (int i = 0; i < n; i++) {
    double both = s->zero[i] == 0 ? fmin(xy[i], xy[n + i]) : 0;
    if (both > worst) at = i, worst = both;
  }
  for (int half = 1; half <= 2 && at >= 0 && !any; half++) {
    s->zero[at] = half;
    any = has_solution(s);
    s->zero[at] = 0;
  }
  return at < 0 || any;
}

/* Whether the problem has no solution, or two that differ in a row whose diagonal entry is not
 * above zero; not where that is not found out. */
static int is_paradoxical(const nsdae_lcp_problem *of)
{
  search s = {.of = of, .strict = -1};
  double size = 0;
  if (of->n > ROWS - 1) return 0;
  if (!has_solution(&s)) return 1;
  for (int i = 0; i < of->n; i++) size = fmax(size, fabs(of->b[i]));
  for (int i = 0; i < of->n; i++) {
    int both = !(of->A[i * (of->lda + 1)] > 0);
    for (int half = 1; half <= 2 && both; half++) {
      s = (search){.of = of, .strict = i, .least = 1e-6 * size};
      s.zero[i] = half;
      both = has_solution(&s) && s.nodes <= NODES;
    }
    if (both) return 1;
  }
  return 0;
}

/* ---- forces of what touches ---- */

typedef struct touching {
  int count, nt, n; /* contacts; tangents of each; count (1 + nt): normal and tangents in turn */
  double G[3 * MOST][3 * MOST], b[3 * MOST], mu;
  int slides[MOST];
  double d[MOST][2];
} touching;

typedef enum mode { OPEN, CLOSED, STICKING, FORWARD, BACKWARD } mode;

/* What F along an edge of contact c does, F_N = 1 and F_T. */
static void append_edge(const touching *p, linear *of, int c, const double *F_T)
{
  int first = c * (1 + p->nt), to = of->columns++;
  for (int i = 0; i < p->n; i++) {
    of->A[i][to] = p->G[i][first];
    for (int l = 0; l < p->nt; l++) of->A[i][to] += F_T[l] * p->G[i][first + 1 + l];
  }
  of->A[p->n][to] = 1;
}

static void append_edges(const touching *p, linear *of, int c, mode is)
{
  if (is == OPEN) return;
  if (p->slides[c] || is == FORWARD || is == BACKWARD) {
    double sense = is == BACKWARD ? -1 : 1;
    double d[2] = {p->slides[c] ? p->d[c][0] : sense, p->slides[c] ? p->d[c][1] : 0};
    append_edge(p, of, c, (double[2]){-p->mu * d[0], -p->mu * d[1]});
    return;
  }
  int edges = p->nt == 1 ? 2 : EDGES;
  double out = p->nt == 1 ? p->mu : p->mu / cos(acos(-1) / EDGES);
  for (int e = 0; e < edges; e++) {
    double turn = 2 * acos(-1) * e / edges;
    append_edge(p, of, c, (double[2]){out * cos(turn), out * sin(turn)});
  }
}

/* What is asked of a solution besides: its forces, and that contact `strict` (-1: none) is not open
 * and closed at once, but moves away or presses by more than so much. */
typedef struct asked {
  double most, away, pressed;
  int strict;
} asked;

/* Keeps row i of the accelerations as a row of its own: sign a_i = 0, or >= above. */
static void keep_row(const touching *p, linear *of, const linear *all, int i, double sign,
                     const double *above)
{
  double *row = of->A[of->rows++];
  for (int j = 0; j < all->columns; j++) row[j] = sign * all->A[i][j];
  if (above) row[of->columns++] = -1;
  row[COLUMNS] = (above ? *above : 0) - sign * p->b[i];
}

/* The normal forces of contacts from .. to, with a variable that is what is left of the bound. */
static void bound_forces(linear *of, const linear *all, const int *owner, int of_contact,
                         double bound, double left)
{
  double *row = of->A[of->rows++];
  for (int j = 0; j < all->columns; j++) row[j] = of_contact < 0 || owner[j] == of_contact;
  row[of->columns++] = left;
  row[COLUMNS] = bound;
}

static int has_forces(const touching *p, const mode *is, const asked *of_it)
{
  static linear edges, of; /* large */
  const double none = 0;
  int owner[COLUMNS];
  memset(&edges, 0, sizeof edges);
  memset(&of, 0, sizeof of);
  for (int c = 0; c < p->count; c++) {
    int from = edges.columns;
    append_edges(p, &edges, c, is[c]);
    for (int j = from; j < edges.columns; j++) owner[j] = c;
  }
  of.columns = edges.columns;
  for (int c = 0; c < p->count; c++) {
    int first = c * (1 + p->nt);
    const double *above = c == of_it->strict ? &of_it->away : &none;
    keep_row(p, &of, &edges, first, 1, is[c] == OPEN ? above : NULL);
    for (int l = 1; l <= p->nt && is[c] == STICKING; l++)
      keep_row(p, &of, &edges, first + l, 1, NULL);
    if (is[c] == FORWARD) keep_row(p, &of, &edges, first + 1, 1, &none);
    if (is[c] == BACKWARD) keep_row(p, &of, &edges, first + 1, -1, &none);
    if (c == of_it->strict && is[c] != OPEN)
      bound_forces(&of, &edges, owner, c, of_it->pressed, -1);
  }
  bound_forces(&of, &edges, owner, -1, of_it->most, 1);
  for (int i = 0; i < of.rows; i++) {
    double f = of.A[i][COLUMNS];
    of.A[i][COLUMNS] = 0;
    of.A[i][of.columns] = f;
  }
  return is_solvable(&of, NULL);
}

/* The next modes; 0 after the last. */
static int next_modes(const touching *p, mode *is)
{
  for (int c = 0; c < p->count; c++) {
    int rubs = !p->slides[c] && p->mu > 0, plane = rubs && p->nt == 1;
    mode last = plane ? BACKWARD : rubs ? STICKING : CLOSED;
    if (is[c] != last) {
      is[c] = plane && is[c] == OPEN ? STICKING : is[c] + 1;
      return 1;
    }
    is[c] = OPEN;
  }
  return 0;
}

/* Whether forces exist that are as asked; closed: of the strict contact, 0 or 1. Where less was
 * asked, as of what rests in space, it is not. */
static int find_forces(const touching *p, const asked *of_it, int closed)
{
  mode is[MOST] = {OPEN};
  int any = 0, c = of_it->strict;
  do {
    int fits = c < 0 || (is[c] != OPEN) == closed;
    if (c >= 0 && p->nt == 2 && !p->slides[c] && p->mu > 0) fits &= is[c] != CLOSED;
    any = fits && has_forces(p, is, of_it);
  } while (!any && next_modes(p, is));
  return any;
}

/* No forces that are not immense, or some with a contact and some without. */
static int is_paradox(const touching *p)
{
  double stop = 0, fastest = 0;
  for (int c = 0; c < p->count; c++) {
    int i = c * (1 + p->nt);
    stop += fabs(p->b[i]) / p->G[i][i];
    fastest = fmax(fastest, fabs(p->b[i]));
  }
  asked all = {MANY * stop, 1e-3 * fastest, 1e-3 * stop, -1};
  int any = p->count == 0 || find_forces(p, &all, 0), two = 0;
  for (int c = 0; c < p->count && any && !two; c++) {
    asked strict = all;
    strict.strict = c;
    two = find_forces(p, &strict, 0) && find_forces(p, &strict, 1);
  }
  return !any || two;
}

/* ---- of a drop ---- */

typedef struct place {
  const drop *d;
  drop_terms at;
  int n, nt, count, contact[MOST]; /* velocities; tangents; what touches */
  double e;
} place;

/* Row l of the c-th of what touches: its normal, then its tangents. */
static const double *row_of(const place *p, int c, int l)
{
  int i = p->contact[c];
  return l == 0 ? p->at.W_N[i] : p->at.W_T[i * p->nt + l - 1];
}

static double rate_of(const place *p, int c, int l, const double *v)
{
  double sum = 0;
  for (int i = 0; i < p->n; i++) sum += row_of(p, c, l)[i] * v[i];
  return sum;
}

static double mass_of(const place *p, int i)
{
  const drop *d = p->d;
  return d->space ? (i < 3 ? d->m : d->J[i - 3]) : (i % 3 < 2 ? d->m : d->J[2]);
}

/* a^T M^-1 b */
static double mobility(const place *p, const double *a, const double *b)
{
  double sum = 0;
  for (int i = 0; i < p->n; i++) sum += a[i] * b[i] / mass_of(p, i);
  return sum;
}

static double energy_of(const place *p, const double *v)
{
  double sum = 0;
  for (int i = 0; i < p->n; i++) sum += mass_of(p, i) * v[i] * v[i] / 2;
  return sum;
}

/* v += M^-1 W change of row l of c. */
static void push(const place *p, int c, int l, double change, double *v)
{
  for (int i = 0; i < p->n; i++) v[i] += row_of(p, c, l)[i] * change / mass_of(p, i);
}

/* v after an impact with restitution e by projected Gauss-Seidel (Jean 1999): P_N >= 0,
 * v_N + e v_N- = 0, P_T against v_T in its cone. 0 where that comes to no end. */
static int collide(const place *p, double e, const double *before, double *v)
{
  double P[MOST][3] = {{0}}, most = 1;
  memcpy(v, before, (size_t)p->n * sizeof *v);
  for (int sweep = 0; sweep < 100000 && most > 1e-14; sweep++) {
    double size = 0;
    most = 0;
    for (int c = 0; c < p->count; c++) {
      double G = mobility(p, row_of(p, c, 0), row_of(p, c, 0)), next[3], rho = 0, length = 0;
      next[0] = fmax(0, P[c][0] - (rate_of(p, c, 0, v) + e * rate_of(p, c, 0, before)) / G);
      push(p, c, 0, next[0] - P[c][0], v);
      for (int l = 1; l <= p->nt; l++) rho += mobility(p, row_of(p, c, l), row_of(p, c, l));
      for (int l = 1; l <= p->nt; l++) {
        next[l] = P[c][l] - rate_of(p, c, l, v) / rho;
        length = hypot(length, next[l]);
      }
      for (int l = 1; l <= p->nt; l++) {
        if (length > p->d->mu * next[0]) next[l] *= p->d->mu * next[0] / length;
        push(p, c, l, next[l] - P[c][l], v);
      }
      for (int l = 0; l <= p->nt; l++) {
        most = fmax(most, fabs(next[l] - P[c][l]));
        size = fmax(size, fabs(P[c][l] = next[l]));
      }
    }
    if (size == 0) return 1;
    most /= size;
  }
  return most <= 1e-10;
}

/* v after it by the law: with e = 0 where there is no solution, between both where it gains. */
static void after_impact(const place *p, const double *before, double *v)
{
  double plastic[DROP_NV], apart[DROP_NV];
  int bounces = collide(p, p->d->e, before, v);
  double gain = energy_of(p, v) - energy_of(p, before);
  if (bounces && gain <= 1e-12 * energy_of(p, before)) return;
  collide(p, 0, before, plastic);
  double loss = energy_of(p, plastic) - energy_of(p, before), share = 0;
  for (int i = 0; i < p->n; i++) apart[i] = v[i] - plastic[i];
  double c = energy_of(p, apart), b = gain - loss - c;
  if (bounces && c > 0) share = (sqrt(fmax(0, b * b - 4 * c * loss)) - b) / (2 * c);
  for (int i = 0; i < p->n; i++) v[i] = plastic[i] + fmax(0, fmin(1, share)) * apart[i];
}

static int approaches(const place *p, const double *v, double slow)
{
  int any = 0;
  for (int c = 0; c < p->count; c++) any |= rate_of(p, c, 0, v) < -slow;
  return any;
}

/* What touches and does not part: of it, what slides faster than `slow` has a direction. */
static void find_touching(const place *p, const double *v, double slow, touching *to)
{
  int at[3 * MOST][2];
  double a[DROP_NV];
  *to = (touching){.nt = p->nt, .mu = p->d->mu};
  for (int i = 0; i < p->n; i++) a[i] = p->at.F[i] / mass_of(p, i);
  for (int c = 0; c < p->count; c++) {
    int i = p->contact[c];
    if (rate_of(p, c, 0, v) > slow) continue;
    double speed = 0;
    for (int l = 0; l <= p->nt; l++) {
      at[to->n][0] = c, at[to->n][1] = l;
      to->b[to->n++] =
          rate_of(p, c, l, a) + (l == 0 ? p->at.omega_N[i] : p->at.omega_T[i * p->nt + l - 1]);
      if (l > 0) speed = hypot(speed, rate_of(p, c, l, v));
    }
    to->slides[to->count] = speed > slow && p->d->mu > 0;
    for (int l = 0; l < p->nt && speed > slow; l++)
      to->d[to->count][l] = rate_of(p, c, 1 + l, v) / speed;
    to->count++;
  }
  for (int i = 0; i < to->n; i++)
    for (int j = 0; j < to->n; j++)
      to->G[i][j] = mobility(p, row_of(p, at[i][0], at[i][1]), row_of(p, at[j][0], at[j][1]));
}

/* With gaps up to `near` closed and velocities up to `slow` zero; hit: whether anything approaches.
 */
static int jams(const drop *d, const double *q, const double *v, double near, double slow, int *hit)
{
  static place p; /* large */
  double after[DROP_NV] = {0}, before[DROP_NV];
  touching t;
  p = (place){.d = d, .n = d->space ? 6 : 3 * d->bodies, .nt = d->space ? 2 : 1};
  drop_find_terms(d, q, v, &p.at);
  for (int i = 0; i < p.at.count && p.count < MOST; i++)
    if (p.at.gap[i] <= near) p.contact[p.count++] = i;
  memcpy(after, v, (size_t)p.n * sizeof *v);
  *hit |= approaches(&p, v, slow);
  for (int impacts = 0; impacts < 100 && approaches(&p, after, slow); impacts++) {
    memcpy(before, after, sizeof before);
    after_impact(&p, before, after);
  }
  drop_find_terms(d, q, after, &p.at);
  find_touching(&p, after, slow, &t);
  return is_paradox(&t);
}

int jam_is_true(const drop *d, const double *q, const double *v, const nsdae_lcp_problem *failed)
{
  double fastest = 0, rtol = d->rtol;
  int hit = 0;
  for (int i = 0; i < (d->space ? 6 : 3 * d->bodies); i++) fastest = fmax(fastest, fabs(v[i]));
  /* what may count as zero, at most, and what the method says that does */
  double near = rtol * fmax(1, fastest) + 1e-8 * d->size, slow = 1e2 * rtol * fmax(1, fastest);
  double nearest = 10 * rtol * (5e-3 * fastest + 1e-2), slowest = 10 * rtol * (fastest + 1e-2);
  if (jams(d, q, v, near, slow, &hit) || jams(d, q, v, nearest, slowest, &hit))
    return JAM_BY_FORCES;
  return failed && hit && is_paradoxical(failed) ? JAM_BY_PROBLEM : 0;
}
