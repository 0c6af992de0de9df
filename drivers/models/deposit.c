#include "deposit.h"

#include <math.h>
#include <stdlib.h>

#include <nsdae/nsdae.h>

enum { SECTORS = 16 };

static const double pi = 3.14159265358979323846;

double deposit_runout(double a)
{
  return a < 1.7 ? 1.24 * a : 1.6 * sqrt(a);
}

double deposit_height(double a)
{
  return a < 0.74 ? a : a < 1.7 ? NAN : 0.88 * pow(a, 1.0 / 6);
}

/* A sphere, and the one above it in the tree of those that hang together. */
typedef struct node {
  double x[3];
  int up, size;
} node;

static int by_x(const void *a, const void *b)
{
  double x = ((const node *)a)->x[0], y = ((const node *)b)->x[0];
  return (x > y) - (x < y);
}

static int root(node *s, int i)
{
  while (s[i].up != i) i = s[i].up = s[s[i].up].up;
  return i;
}

/* Union-find; in the order of x only a slice of the spheres can be near one. */
static void join(node *s, int n, double reach)
{
  for (int i = 0; i < n; i++) s[i].up = i;
  for (int i = 0; i < n; i++)
    for (int j = i + 1; j < n && s[j].x[0] - s[i].x[0] < reach; j++) {
      double d[3];
      for (int k = 0; k < 3; k++) d[k] = s[j].x[k] - s[i].x[k];
      if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < reach * reach) s[root(s, j)].up = root(s, i);
    }
}

/* Root of the largest tree. */
static int largest(node *s, int n)
{
  int best = root(s, 0);
  for (int i = 0; i < n; i++) {
    int r = root(s, i);
    if (++s[r].size > s[best].size) best = r;
  }
  return best;
}

/* Rim and top of the pile; a sector without a sphere of it has its rim on the axis. */
static void outline(node *s, int n, double r, int pile, deposit *d)
{
  double rim[SECTORS] = {0}, square = 0;
  for (int i = 0; i < n; i++) {
    const double *x = s[i].x;
    int sector = (int)((atan2(x[1], x[0]) / pi + 1) / 2 * (double)SECTORS) % SECTORS;
    d->lowest = fmin(d->lowest, x[2]);
    if (root(s, i) != pile) continue;
    rim[sector] = fmax(rim[sector], hypot(x[0], x[1]) + r);
    d->height = fmax(d->height, x[2]);
  }
  for (int k = 0; k < SECTORS; k++) d->radius += rim[k] / (double)SECTORS;
  for (int k = 0; k < SECTORS; k++) square += pow(rim[k] - d->radius, 2) / (double)SECTORS;
  d->scatter = sqrt(square);
}

int deposit_measure(int n, double r, const double *place, deposit *result)
{
  node *s = malloc((size_t)n * sizeof *s);
  if (!s) return NSDAE_E_MEMORY;
  for (int i = 0; i < n; i++)
    s[i] = (node){.x = {place[3 * i], place[3 * i + 1], place[3 * i + 2]}};
  qsort(s, (size_t)n, sizeof *s, by_x);
  join(s, n, 2.1 * r);
  int pile = largest(s, n);
  *result = (deposit){.pile = s[pile].size, .lowest = s[0].x[2]};
  outline(s, n, r, pile, result);
  free(s);
  return NSDAE_OK;
}
