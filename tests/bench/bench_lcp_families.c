#include "bench_lcp_families.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const lcp_family_names[LCP_FAMILIES] = {"definite", "frictionless", "friction"};

static const double neighbour = 1e-4;

static double *numbers(int count)
{
  double *a = calloc((size_t)count + 1, sizeof *a);
  if (!a) abort();
  return a;
}

/* A = G^T G / n + 1e-2, b, all of G and b uniform in -1 .. 1. */
static void definite(lcp_case *c, random_state *r)
{
  int n = c->n;
  double *G = numbers(n * n);
  random_matrix(r, n, n, G, n);
  for (int j = 0; j < n; j++)
    for (int i = 0; i <= j; i++) {
      double sum = i == j ? 1e-2 * n : 0;
      for (int k = 0; k < n; k++) sum += G[i * n + k] * G[j * n + k];
      c->A[j * n + i] = c->A[i * n + j] = sum / n;
    }
  random_matrix(r, n, 1, c->b, n);
  random_matrix(r, n, 1, c->near, n);
  for (int i = 0; i < n; i++) c->near[i] = c->b[i] + neighbour * c->near[i];
  free(G);
}

/* Planar rigid bodies in a heap: contact i pushes body a and pulls body b, one of its nearest
 * neighbours or the ground (-1). */
typedef struct heap {
  int bodies, contacts;
  int *a, *b;
  double *direction;    /* 2 a contact: the normal; the tangent is it, turned */
  double *lever;        /* 4 a contact: of normal and tangent on a and on b */
  double *inverse_mass; /* 3 a body */
  double *v;            /* 3 a body */
} heap;

/* Row of contact i along kind 0 (normal) or 1 (tangent) at body a (1) or b (-1). */
static void arm(const heap *h, int i, int kind, int side, double w[3])
{
  const double *d = h->direction + 2 * i;
  w[0] = side * (kind == 0 ? d[0] : -d[1]);
  w[1] = side * (kind == 0 ? d[1] : d[0]);
  w[2] = side * h->lever[4 * i + 2 * (side < 0) + kind];
}

static void add(const heap *h, int body, const double *one, const double *other, double *sum)
{
  for (int k = 0; k < 3; k++) *sum += one[k] * h->inverse_mass[3 * body + k] * other[k];
}

/* (W_kind_i)^T M^-1 W_other_j */
static double delassus(const heap *h, int i, int kind, int j, int other)
{
  double sum = 0, w[3], u[3];
  for (int s = 1; s >= -1; s -= 2)
    for (int t = 1; t >= -1; t -= 2) {
      int body = s > 0 ? h->a[i] : h->b[i];
      if (body < 0 || body != (t > 0 ? h->a[j] : h->b[j])) continue;
      arm(h, i, kind, s, w);
      arm(h, j, other, t, u);
      add(h, body, w, u, &sum);
    }
  return sum;
}

static double relative_velocity(const heap *h, int i, int kind, const double *v)
{
  double sum = 0, w[3];
  for (int s = 1; s >= -1; s -= 2) {
    int body = s > 0 ? h->a[i] : h->b[i];
    if (body < 0) continue;
    arm(h, i, kind, s, w);
    for (int k = 0; k < 3; k++) sum += w[k] * v[3 * body + k];
  }
  return sum;
}

static void random_contact(heap *h, int i, random_state *r)
{
  double angle = 3.14159265358979 * random_number(r);
  h->a[i] = random_int(r, 0, h->bodies - 1);
  h->b[i] = h->a[i] - random_int(r, 1, 3);
  if (h->b[i] < 0) h->b[i] = -1;
  h->direction[2 * i] = cos(angle);
  h->direction[2 * i + 1] = sin(angle);
  for (int k = 0; k < 4; k++) h->lever[4 * i + k] = 0.5 * random_number(r);
}

static void copy_contact(heap *h, int i, int from)
{
  h->a[i] = h->a[from];
  h->b[i] = h->b[from];
  memcpy(h->direction + 2 * i, h->direction + 2 * from, 2 * sizeof *h->direction);
  memcpy(h->lever + 4 * i, h->lever + 4 * from, 4 * sizeof *h->lever);
}

/* repeat: every third contact is the one before it once more, as between two faces. */
static heap heap_create(int bodies, int contacts, int repeat, random_state *r)
{
  heap h = {.bodies = bodies, .contacts = contacts};
  h.a = malloc((size_t)contacts * sizeof *h.a);
  h.b = malloc((size_t)contacts * sizeof *h.b);
  if (!h.a || !h.b) abort();
  h.direction = numbers(2 * contacts);
  h.lever = numbers(4 * contacts);
  h.inverse_mass = numbers(3 * bodies);
  h.v = numbers(3 * bodies);
  for (int i = 0; i < contacts; i++)
    if (repeat && i % 3 == 2)
      copy_contact(&h, i, i - 1);
    else
      random_contact(&h, i, r);
  for (int i = 0; i < bodies; i++) {
    double mass = 1 + 0.5 * random_number(r);
    h.inverse_mass[3 * i] = h.inverse_mass[3 * i + 1] = 1 / mass;
    h.inverse_mass[3 * i + 2] = 12 / mass;
  }
  random_matrix(r, 3 * bodies, 1, h.v, 3 * bodies);
  return h;
}

static void heap_destroy(heap *h)
{
  free(h->a);
  free(h->b);
  free(h->direction);
  free(h->lever);
  free(h->inverse_mass);
  free(h->v);
}

/* A = W_N^T M^-1 W_N, b = W_N^T v. */
static void set_frictionless(const heap *h, lcp_case *c)
{
  int n = c->n;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) c->A[j * n + i] = delassus(h, i, 0, j, 0);
}

static void set_b(const heap *h, int kinds, double *b)
{
  for (int kind = 0; kind < kinds; kind++)
    for (int i = 0; i < h->contacts; i++)
      b[kind * h->contacts + i] = relative_velocity(h, i, kind, h->v);
}

/* x = [Lambda_N, Lambda_R, xi_L], y = [xi_N, xi_R, Lambda_L] with Lambda_T = Lambda_R - mu
 * Lambda_N: the columns of Lambda_N are W_N - mu W_T. */
static void set_friction(const heap *h, random_state *r, lcp_case *c)
{
  int n = c->n, k = h->contacts;
  for (int j = 0; j < k; j++) {
    double mu = 0.3 + 0.2 * random_number(r);
    for (int kind = 0; kind < 2; kind++)
      for (int i = 0; i < k; i++) {
        double tangent = delassus(h, i, kind, j, 1);
        c->A[j * n + kind * k + i] = delassus(h, i, kind, j, 0) - mu * tangent;
        c->A[(k + j) * n + kind * k + i] = tangent;
      }
    c->A[(2 * k + j) * n + k + j] = 1;
    c->A[j * n + 2 * k + j] = 2 * mu;
    c->A[(k + j) * n + 2 * k + j] = -1;
  }
}

static void contact(lcp_case *c, int friction, random_state *r)
{
  int contacts = friction ? c->n / 3 : c->n;
  int bodies = friction ? (contacts + 1) / 2 : (contacts + 2) / 3;
  heap h = heap_create(bodies, contacts, !friction, r);
  if (friction)
    set_friction(&h, r, c);
  else
    set_frictionless(&h, c);
  set_b(&h, friction ? 2 : 1, c->b);
  for (int i = 0; i < 3 * bodies; i++) h.v[i] += neighbour * random_number(r);
  set_b(&h, friction ? 2 : 1, c->near);
  heap_destroy(&h);
}

static int is_trivial(const lcp_case *c)
{
  for (int i = 0; i < c->n; i++)
    if (c->b[i] < 0 && c->near[i] < 0) return 0;
  return 1;
}

lcp_case lcp_case_create(int family, int n, random_state *r)
{
  lcp_case c = {.n = n, .A = numbers(n * n), .b = numbers(n), .near = numbers(n)};
  do {
    memset(c.A, 0, (size_t)(n * n) * sizeof *c.A);
    if (family == LCP_DEFINITE)
      definite(&c, r);
    else
      contact(&c, family == LCP_FRICTION, r);
  } while (is_trivial(&c));
  return c;
}

void lcp_case_destroy(lcp_case *c)
{
  free(c->A);
  free(c->b);
  free(c->near);
}
