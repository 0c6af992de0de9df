#include "work.h"

#include <math.h>
#include <stddef.h>

#include "disjoint_sets.h"
#include "vector.h"

/* Sizes within these factors of one are let be, and are even enough when at work. */
enum { WORTH_IT = 256, EVEN = 4, ROUNDS = 12 };

/* No scale is further from one than 2 to this power. */
enum { FARTHEST = 1000 };

static int limit(long exponent, int least, int most)
{
  return exponent < least ? least : exponent > most ? most : (int)exponent;
}

/* Largest entries by magnitude of the rows and columns. */
static void largest_entries(int n, const double *A, double *restrict of_row,
                            double *restrict of_column)
{
  for (int i = 0; i < n; i++) of_row[i] = 0;
  for (int j = 0; j < n; j++) {
    const double *restrict column = A + (size_t)j * (size_t)n;
    for (int i = 0; i < n; i++)
      of_row[i] = fabs(column[i]) > of_row[i] ? fabs(column[i]) : of_row[i];
    of_column[j] = nsdae_largest(n, column);
  }
}

static int uneven(int n, const double *sizes, double ratio)
{
  for (int i = 0; i < n; i++)
    if (sizes[i] > ratio || (sizes[i] < 1 / ratio && sizes[i] > 0)) return 1;
  return 0;
}

/* Power of two near 1 / sqrt(size). */
static double root_scale(double size)
{
  int exponent;
  if (!(size > 0)) return 1;
  frexp(size, &exponent);
  return ldexp(1, -exponent / 2);
}

/* Multiplies a scale; returns by what. */
static double grow(double *scale, double by)
{
  int before = ilogb(*scale), after = limit((long)before + ilogb(by), -FARTHEST, FARTHEST);
  *scale = ldexp(1, after);
  return ldexp(1, after - before);
}

/* Scales grow by these, as far as they may. */
static void scale(int n, double *A, double *row, double *column, double *by_row, double *by_column)
{
  for (int i = 0; i < n; i++) {
    by_row[i] = grow(row + i, by_row[i]);
    by_column[i] = grow(column + i, by_column[i]);
  }
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) A[(size_t)j * (size_t)n + (size_t)i] *= by_row[i] * by_column[j];
}

/* ---- geometric means */

/* Power of two near one over the geometric mean of the entries that are not zero. */
static double mean_scale(int n, const double *a, size_t stride)
{
  long sum = 0, count = 0;
  int largest = -FARTHEST;
  for (size_t i = 0; i < (size_t)n; i++) {
    if (a[i * stride] == 0) continue;
    int power = ilogb(a[i * stride]);
    if (power > largest) largest = power;
    sum += power;
    count++;
  }
  long mean = count > 0 ? lrint((double)sum / (double)count) : 0;
  return ldexp(1, limit(-mean, -FARTHEST, FARTHEST - largest)); /* without overflow */
}

/* ---- sizes of independent blocks */

/* Multiplies the rows of a block by the power of two, and divides the columns by it, that brings
 * its largest b_i to the size of one: A stays, and x and y shrink alike. */
static void shift_block(int n, const double *b, double *row, double *column, const int *node,
                        int count)
{
  int none = -10000, largest = none, low = -2 * FARTHEST, high = 2 * FARTHEST;
  for (int k = 0; k < count; k++) {
    int i = node[k], power = i < n ? ilogb(row[i]) : -ilogb(column[i - n]);
    if (-FARTHEST - power > low) low = -FARTHEST - power;
    if (FARTHEST - power < high) high = FARTHEST - power;
    if (i < n && b[i] != 0 && ilogb(b[i]) + power > largest) largest = ilogb(b[i]) + power;
  }
  if (largest == none) return;
  int shift = limit(-largest, low, high);
  for (int k = 0; k < count; k++) {
    double *of_row = row + node[k], *of_column = column + (node[k] - n);
    if (node[k] < n)
      *of_row = ldexp(*of_row, shift);
    else
      *of_column = ldexp(*of_column, -shift);
  }
}

/* ---- largest entries */

/* Then the largest entries (Ruiz, RAL-TR-2001-034): rows and columns by the root of their size,
 * until they are even. */
static void even_sizes(int n, double *A, double *row, double *column, double *work)
{
  double *by_row = work, *by_column = work + n;
  for (int round = 0; round < ROUNDS; round++) {
    largest_entries(n, A, by_row, by_column);
    if (!uneven(n, by_row, EVEN) && !uneven(n, by_column, EVEN)) return;
    for (int i = 0; i < n; i++) {
      by_row[i] = root_scale(by_row[i]);
      by_column[i] = root_scale(by_column[i]);
    }
    scale(n, A, row, column, by_row, by_column);
  }
}

void nsdae_equilibrate(int n, double *A, double *b, double *row, double *column, double *work,
                       int *iwork)
{
  for (int i = 0; i < n; i++) row[i] = column[i] = 1;
  /* Even: the largest entries of all rows and columns that are not zero are near enough to one. */
  largest_entries(n, A, work, work + n);
  int even = !uneven(n, work, WORTH_IT) && !uneven(n, work + n, WORTH_IT);
  double most = nsdae_largest(n, b); /* moderate: far from the ends of the range, or zero */
  if (even && (most == 0 || (most > 0x1p-500 && most < 0x1p500))) return;
  /* Geometric means of rows and columns in turn: least squares in the logarithms (Curtis and Reid,
   * J. Inst. Math. Appl. 10, 1972), which finds the scales of a matrix that was scaled. */
  double *by_row = work, *by_column = work + n;
  for (int round = 0; round < 2 * ROUNDS && !even; round++) {
    for (int i = 0; i < n; i++) {
      by_row[i] = round % 2 == 0 ? mean_scale(n, A + i, (size_t)n) : 1;
      by_column[i] = round % 2 == 1 ? mean_scale(n, A + (size_t)i * (size_t)n, 1) : 1;
    }
    scale(n, A, row, column, by_row, by_column);
  }
  if (!even) even_sizes(n, A, row, column, work);
  /* Rows (i) and columns (n + j) in disjoint sets, those that entries join: blocks have no common
   * scale but that of b. */
  int *set = iwork, *node = iwork + 2 * n;
  nsdae_sets_begin(set, 2 * n);
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      if (A[(size_t)j * (size_t)n + (size_t)i] != 0) nsdae_sets_join(set, i, n + j);
  for (int root = 0; root < n; root++) {
    int count = 0;
    for (int k = root; k < 2 * n && set[root] == root; k++)
      if (nsdae_sets_root(set, k) == root) node[count++] = k;
    shift_block(n, b, row, column, node, count);
  }
  for (int i = 0; i < n; i++) b[i] = ldexp(b[i], ilogb(row[i]));
}
