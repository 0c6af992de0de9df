#include "lcp_families.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "random.h"

enum { MOST_EDGES = 8, FREEDOM = 6 };
enum { OPEN, SLIDE, STICK, GRAZE, MODES };

/* Contacts: relative velocities are J v, J [rows x freedom] dense, rows = contacts * directions. */
typedef struct contacts {
  int count, directions; /* directions: 1 normal, 2 in the plane, 3 in space */
  int edges;             /* of the friction polygon; 0: the 3-row form or none */
  int rows;              /* of the LCP for each contact */
  int freedom;
  double *J, *inverse_mass, *W, *lambda, *v;
  double mu;
} contacts;

const char *lcp_family_name(int family)
{
  static const char *const name[FAMILIES] = {"positive definite", "semidefinite",   "frictionless",
                                             "planar, 3 rows",    "planar, 4 rows", "pyramid of 4",
                                             "pyramid of 8",      "restitution",    "badly scaled",
                                             "degenerate",        "infeasible",     "any"};
  return name[family];
}

int lcp_family_least(int family)
{
  static const int least[FAMILIES] = {3, 3, 3, 3, 4, 6, 10, 6, 3, 3, 3, 3};
  return least[family];
}

double lcp_sample_uniform(lcp_sample *s, double low, double high)
{
  return random_between(&s->state, low, high);
}

int lcp_sample_pick(lcp_sample *s, int count)
{
  return random_below(&s->state, count);
}

static double *room(size_t count)
{
  double *block = calloc(count > 0 ? count : 1, sizeof *block);
  if (!block) {
    fprintf(stderr, "lcp_families: no memory for %zu numbers\n", count);
    exit(1);
  }
  return block;
}

lcp_sample lcp_sample_create(int n, unsigned long long seed)
{
  size_t size = (size_t)n;
  return (lcp_sample){.capacity = n,
                      .A = room(size * size),
                      .b = room(size),
                      .x = room(size),
                      .row = room(size),
                      .column = room(size),
                      .state = seed};
}

void lcp_sample_release(lcp_sample *s)
{
  free(s->A);
  free(s->b);
  free(s->x);
  free(s->row);
  free(s->column);
  *s = (lcp_sample){0};
}

static double *entry(lcp_sample *s, int i, int j)
{
  return s->A + (size_t)j * (size_t)s->n + (size_t)i;
}

/* b = y - A x for x, y >= 0, x'y = 0; both zero for a share of the pairs. */
static void plant(lcp_sample *s, double degenerate, int integers)
{
  for (int i = 0; i < s->n; i++) {
    double value = integers ? 1 + lcp_sample_pick(s, 4) : lcp_sample_uniform(s, 0.01, 1);
    if (lcp_sample_uniform(s, 0, 1) < degenerate) value = 0;
    int positive = lcp_sample_pick(s, 2);
    s->x[i] = positive ? value : 0;
    s->b[i] = positive ? 0 : value;
  }
  for (int j = 0; j < s->n; j++)
    for (int i = 0; i < s->n; i++) s->b[i] -= *entry(s, i, j) * s->x[j];
  s->known = FAMILY_SOLUTION;
}

/* A = B B^T + diagonal + skew, B n x rank. */
static void draw_monotone(lcp_sample *s, int rank, double diagonal, int integers)
{
  size_t n = (size_t)s->n;
  double *B = room(n * (size_t)rank), skew = lcp_sample_pick(s, 2);
  for (size_t i = 0; i < n * (size_t)rank; i++)
    B[i] = integers ? lcp_sample_pick(s, 3) - 1 : lcp_sample_uniform(s, -1, 1);
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i <= j; i++) {
      double sum = i == j ? diagonal : 0;
      double turn = integers ? lcp_sample_pick(s, 3) - 1 : lcp_sample_uniform(s, -1, 1);
      for (size_t k = 0; k < (size_t)rank; k++) sum += B[k * n + i] * B[k * n + j];
      if (i == j) turn = 0;
      s->A[j * n + i] = sum + skew * turn;
      s->A[i * n + j] = sum - skew * turn;
    }
  free(B);
}

/* Row of a point on a body: direction d and lever arm r, d and r x d. */
static void add_body(lcp_sample *s, contacts *c, int body, double sign, double d[3][3])
{
  double r[3];
  int per_body = c->directions == 3 ? 6 : 3;
  size_t rows = (size_t)(c->count * c->directions);
  for (int i = 0; i < 3; i++) r[i] = lcp_sample_uniform(s, -1, 1);
  if (per_body == 3) r[2] = 0;
  for (int k = 0; k < c->directions; k++) {
    const double *e = d[k];
    double turn[3] = {r[1] * e[2] - r[2] * e[1], r[2] * e[0] - r[0] * e[2],
                      r[0] * e[1] - r[1] * e[0]};
    double *J = c->J + (size_t)(body * per_body) * rows + (size_t)k;
    for (int i = 0; i < per_body; i++) {
      double value = per_body == 3 ? (i < 2 ? e[i] : turn[2]) : (i < 3 ? e[i] : turn[i - 3]);
      J[(size_t)i * rows] += sign * value;
    }
  }
}

static void frame(lcp_sample *s, const contacts *c, double d[3][3])
{
  double a = lcp_sample_uniform(s, 0, 6.283185307179586), h = lcp_sample_uniform(s, -1, 1);
  double plane[3][3] = {{cos(a), sin(a), 0}, {-sin(a), cos(a), 0}, {0, 0, 1}};
  double ring = sqrt(1 - h * h);
  double space[3][3] = {
      {ring * cos(a), ring * sin(a), h}, {-sin(a), cos(a), 0}, {-h * cos(a), -h * sin(a), ring}};
  memcpy(d, c->directions == 3 ? space : plane, sizeof plane);
}

static void measure_contacts(contacts *c)
{
  size_t rows = (size_t)(c->count * c->directions);
  for (size_t k = 0; k < (size_t)c->freedom; k++)
    for (size_t j = 0; j < rows; j++) {
      double weight = c->J[k * rows + j] * c->inverse_mass[k];
      for (size_t i = 0; weight != 0 && i < rows; i++)
        c->W[j * rows + i] += c->J[k * rows + i] * weight;
    }
}

/* Contacts between bodies and the ground; a share of them repeats an earlier one. */
static contacts draw_contacts(lcp_sample *s, int count, int directions, double repeat)
{
  int per_body = directions == 3 ? 6 : 3, bodies = 1 + count * directions / per_body;
  contacts c = {.count = count, .directions = directions, .freedom = bodies * per_body};
  size_t rows = (size_t)(count * directions);
  c.J = room(rows * (size_t)c.freedom);
  c.inverse_mass = room((size_t)c.freedom);
  c.W = room(rows * rows);
  c.lambda = room(rows);
  c.v = room(rows);
  c.mu = lcp_sample_uniform(s, 0.05, 1.5);
  for (int i = 0; i < c.freedom; i++) c.inverse_mass[i] = pow(10, lcp_sample_uniform(s, -1, 1));
  double *all = c.J;
  for (int i = 0; i < count; i++) {
    double d[3][3];
    size_t shift = (size_t)(i * directions);
    c.J = all + shift;
    if (i > 0 && lcp_sample_uniform(s, 0, 1) < repeat) {
      size_t from = (size_t)(lcp_sample_pick(s, i) * directions);
      for (size_t k = 0; k < (size_t)c.freedom; k++)
        memcpy(all + k * rows + shift, all + k * rows + from, (size_t)directions * sizeof *all);
      continue;
    }
    int first = lcp_sample_pick(s, bodies), second = lcp_sample_pick(s, bodies + 1);
    frame(s, &c, d);
    add_body(s, &c, first, 1, d);
    if (second != first && second < bodies) add_body(s, &c, second, -1, d);
  }
  c.J = all;
  measure_contacts(&c);
  return c;
}

static void release_contacts(contacts *c)
{
  free(c->J);
  free(c->inverse_mass);
  free(c->W);
  free(c->lambda);
  free(c->v);
}

/* Component k (0 normal, 1, 2 tangential) of unknown l of a contact: E_Q, and with mu = 0 E_P. */
static double share(const contacts *c, int k, int l, double mu)
{
  const double turn = 6.283185307179586477;
  if (c->directions == 1) return 1;
  if (k == 0) return l == 0;
  if (c->edges == 0) return l == 0 ? -mu : l == 1; /* Lambda_T = Lambda_R - mu Lambda_N */
  if (l == 0 || l > c->edges) return 0;
  double angle = turn * (l - 1) / c->edges;
  double value = k == 1 ? cos(angle) : sin(angle);
  return fabs(value) < 1e-15 ? 0 : value;
}

/* What couples the unknowns of one contact. */
static void couple(const contacts *c, lcp_sample *s, int first)
{
  int last = first + c->rows - 1;
  if (c->directions == 1) return;
  if (c->edges == 0) {
    *entry(s, first + 1, last) += 1;
    *entry(s, last, first) += 2 * c->mu;
    *entry(s, last, first + 1) -= 1;
    return;
  }
  *entry(s, last, first) += c->mu;
  for (int j = first + 1; j < last; j++) {
    *entry(s, j, last) += 1;
    *entry(s, last, j) -= 1;
  }
}

/* A = E_P^T W E_Q + N, b = E_P^T (v - W Lambda). */
static void assemble(const contacts *c, lcp_sample *s)
{
  int d = c->directions, rows = c->count * d;
  s->n = c->count * c->rows;
  memset(s->A, 0, (size_t)s->n * (size_t)s->n * sizeof *s->A);
  for (int i = 0; i < s->n; i++) s->b[i] = 0;
  double *q = room((size_t)rows);
  for (int i = 0; i < rows; i++) {
    q[i] = c->v[i];
    for (int j = 0; j < rows; j++)
      q[i] -= c->W[(size_t)j * (size_t)rows + (size_t)i] * c->lambda[j];
  }
  for (int i = 0; i < s->n; i++)
    for (int k = 0; k < d; k++) {
      double p = share(c, k, i % c->rows, 0);
      int row = i / c->rows * d + k;
      if (p == 0) continue;
      s->b[i] += p * q[row];
      for (int j = 0; j < s->n; j++)
        for (int l = 0; l < d; l++) {
          int column = j / c->rows * d + l;
          *entry(s, i, j) += p * c->W[(size_t)column * (size_t)rows + (size_t)row] *
                             share(c, l, j % c->rows, c->mu);
        }
    }
  for (int i = 0; i < c->count; i++) couple(c, s, i * c->rows);
  free(q);
}

/* Velocities, impulses and the solution of contact i in that mode. */
static void choose_mode(lcp_sample *s, contacts *c, int i, int mode)
{
  int d = c->directions, edge = lcp_sample_pick(s, c->edges > 0 ? c->edges : 2);
  double *v = c->v + i * d, *lambda = c->lambda + i * d, *x = s->x + i * c->rows;
  double push = mode == OPEN || mode == GRAZE ? 0 : lcp_sample_uniform(s, 0.1, 1);
  double slip = mode == STICK || mode == GRAZE ? 0 : lcp_sample_uniform(s, 0.1, 1);
  v[0] = mode == OPEN ? lcp_sample_uniform(s, 0.1, 1) : 0;
  lambda[0] = x[0] = push;
  if (d == 1) return;
  double held = mode == STICK ? lcp_sample_uniform(s, 0, 1) : 1;
  if (c->edges == 0) { /* edge 0: xi_L = slip, Lambda_R = 2 mu push */
    v[1] = edge == 0 ? -slip : slip;
    x[1] = edge == 0 ? 2 * c->mu * push * held : (1 - held) * 2 * c->mu * push;
    x[2] = edge == 0 ? slip : 0;
    lambda[1] = x[1] - c->mu * push;
    return;
  }
  /* slip against the edge, turned by less than half the angle between edges */
  double half = d == 3 ? 3.1415926535 / c->edges : 0, turn = lcp_sample_uniform(s, -half, half);
  double e[2] = {share(c, 1, 1 + edge, 0), share(c, 2, 1 + edge, 0)};
  double w[2] = {cos(turn) * e[0] - sin(turn) * e[1], sin(turn) * e[0] + cos(turn) * e[1]};
  x[1 + edge] = c->mu * push * held;
  x[c->rows - 1] = 0;
  for (int k = 1; k < d; k++) {
    v[k] = -slip * w[k - 1];
    lambda[k] = x[1 + edge] * e[k - 1];
    x[c->rows - 1] -= e[k - 1] * v[k];
  }
}

/* directions and rows of the forms of contact, from the frictionless one on */
static const struct {
  int directions, edges, rows;
} form[] = {{1, 0, 1}, {2, 0, 3}, {2, 2, 4}, {3, 4, 6}, {3, 8, 10}};

static contacts draw_form(lcp_sample *s, int number, int n, double repeat)
{
  int rows = form[number].rows, count = n / rows;
  contacts c = draw_contacts(s, count > 0 ? count : 1, form[number].directions, repeat);
  c.edges = form[number].edges;
  c.rows = rows;
  return c;
}

static void draw_contact_problem(lcp_sample *s, int number, int n, double degenerate)
{
  contacts c = draw_form(s, number, n, number == 0 ? 0.4 : 0.1);
  for (int i = 0; i < c.count * c.rows; i++) s->x[i] = 0;
  for (int i = 0; i < c.count; i++) {
    int graze = lcp_sample_uniform(s, 0, 1) < degenerate;
    choose_mode(s, &c, i, graze ? GRAZE : lcp_sample_pick(s, 3));
  }
  assemble(&c, s);
  s->known = FAMILY_SOLUTION;
  release_contacts(&c);
}

/* J v of one velocity v and the same e for both directions: b^T x = 0 for every x that moves
 * nothing, and the copositive form of the problem has a solution (Anitescu and Potra, Nonlinear
 * Dynam. 14, 1997, theorem 2); which, is not known. */
static void draw_restitution(lcp_sample *s, int n)
{
  int number = 1 + lcp_sample_pick(s, n >= 10 ? 4 : n >= 6 ? 3 : n >= 4 ? 2 : 1);
  contacts c = draw_form(s, number, n, 0.1);
  size_t rows = (size_t)(c.count * c.directions);
  double e = lcp_sample_uniform(s, 0, 1);
  for (size_t k = 0; k < (size_t)c.freedom; k++) {
    double speed = lcp_sample_uniform(s, -1, 1);
    for (size_t i = 0; i < rows; i++) c.v[i] += (1 + e) * c.J[k * rows + i] * speed;
  }
  assemble(&c, s);
  for (int i = 0; i < s->n; i++) s->x[i] = 0;
  s->known = FAMILY_SOLUTION;
  release_contacts(&c);
}

static void rescale(lcp_sample *s)
{
  for (int i = 0; i < s->n; i++) {
    s->row[i] = pow(10, lcp_sample_uniform(s, -8, 8));
    s->column[i] = pow(10, lcp_sample_uniform(s, -8, 8));
    s->x[i] /= s->column[i];
    s->b[i] *= s->row[i];
  }
  for (int j = 0; j < s->n; j++)
    for (int i = 0; i < s->n; i++) *entry(s, i, j) *= s->row[i] * s->column[j];
}

/* A^T u = -t < 0 and b^T u < 0 by a change of rank one of random data. */
static void draw_infeasible(lcp_sample *s)
{
  int n = s->n;
  double *u = room((size_t)n), square = 0, along = lcp_sample_uniform(s, 0.1, 1);
  for (int i = 0; i < n; i++) {
    s->x[i] = 0;
    u[i] = lcp_sample_uniform(s, 0.1, 1);
    s->b[i] = lcp_sample_uniform(s, -1, 1);
    square += u[i] * u[i];
    along += u[i] * s->b[i];
  }
  for (int i = 0; i < n; i++) s->b[i] -= along * u[i] / square;
  for (int j = 0; j < n; j++) {
    double sum = lcp_sample_uniform(s, 0.01, 1);
    for (int i = 0; i < n; i++) {
      *entry(s, i, j) = lcp_sample_uniform(s, -1, 1);
      sum += u[i] * *entry(s, i, j);
    }
    for (int i = 0; i < n; i++) *entry(s, i, j) -= sum * u[i] / square;
  }
  s->known = FAMILY_NO_SOLUTION;
  free(u);
}

static void draw_any(lcp_sample *s)
{
  for (int i = 0; i < s->n * s->n; i++) s->A[i] = lcp_sample_uniform(s, -1, 1);
  for (int i = 0; i < s->n; i++) {
    s->b[i] = lcp_sample_uniform(s, -1, 1);
    s->x[i] = 0;
  }
  s->known = FAMILY_OPEN;
}

/* A family that has a solution and room in n rows. */
static int another(lcp_sample *s, int n)
{
  int family = lcp_sample_pick(s, FAMILY_RESTITUTION);
  return n < lcp_family_least(family) ? FAMILY_DEFINITE : family;
}

static void draw(lcp_sample *s, int family, int n, double degenerate)
{
  int integers = degenerate > 0;
  s->n = n;
  if (family == FAMILY_DEFINITE || family == FAMILY_SEMIDEFINITE) {
    int whole = family == FAMILY_DEFINITE;
    draw_monotone(s, whole ? n : (n + 1) / 2, whole ? integers + 0.1 : 0, integers);
    plant(s, degenerate, integers);
  } else if (family < FAMILY_RESTITUTION)
    draw_contact_problem(s, family - FAMILY_FRICTIONLESS, n, degenerate);
  else if (family == FAMILY_RESTITUTION)
    draw_restitution(s, n);
  else if (family == FAMILY_SCALED || family == FAMILY_DEGENERATE)
    draw(s, another(s, n), n, family == FAMILY_DEGENERATE ? 0.5 : 0);
  else if (family == FAMILY_INFEASIBLE)
    draw_infeasible(s);
  else
    draw_any(s);
}

void lcp_sample_draw(lcp_sample *s, int family, int n)
{
  if (n > s->capacity) n = s->capacity;
  for (int i = 0; i < n; i++) s->row[i] = s->column[i] = 1;
  draw(s, family, n, 0);
  if (family == FAMILY_SCALED) rescale(s);
}
