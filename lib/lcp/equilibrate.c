#include "equilibrate.h"

#include <math.h>
#include <stddef.h>

/* max |a_i|; four at a time, for the latency of a comparison. */
static double largest(int n, const double *a)
{
  double most[4] = {0}, rest = 0;
  int i = 0;
  for (; i + 4 <= n; i += 4)
    for (int k = 0; k < 4; k++) most[k] = fabs(a[i + k]) > most[k] ? fabs(a[i + k]) : most[k];
  for (; i < n; i++) rest = fabs(a[i]) > rest ? fabs(a[i]) : rest;
  for (int k = 0; k < 4; k++) rest = most[k] > rest ? most[k] : rest;
  return rest;
}

/* Sizes within these factors of one are let be, and are even enough when at work. */
enum { WORTH_IT = 256, EVEN = 4, ROUNDS = 12, FARTHEST = 400 };

/* Largest entries by magnitude of the rows and columns. */
static void measure(int n, const double *A, int lda, double *restrict of_row,
                    double *restrict of_column)
{
  for (int i = 0; i < n; i++) of_row[i] = 0;
  for (int j = 0; j < n; j++) {
    const double *restrict column = A + (size_t)j * (size_t)lda;
    for (int i = 0; i < n; i++)
      of_row[i] = fabs(column[i]) > of_row[i] ? fabs(column[i]) : of_row[i];
    of_column[j] = largest(n, column);
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

static void scale(int n, double *A, double *b, const double *by_row, const double *by_column)
{
  for (int j = 0; j < n; j++) {
    double *column = A + (size_t)j * (size_t)n;
    for (int i = 0; i < n; i++) column[i] *= by_row[i] * by_column[j];
    b[j] *= by_row[j];
  }
}

/* Power of two near one over the geometric mean of the entries that are not zero. */
static double mean_scale(int n, const double *a, size_t stride)
{
  long sum = 0, count = 0;
  for (size_t i = 0; i < (size_t)n; i++) {
    if (a[i * stride] == 0) continue;
    sum += ilogb(a[i * stride]);
    count++;
  }
  return count > 0 ? ldexp(1, (int)-lrint((double)sum / (double)count)) : 1;
}

/* Geometric means of rows and columns in turn: least squares in the logarithms (Curtis and Reid, J.
 * Inst. Math. Appl. 10, 1972), which finds the scales of a matrix that was scaled. */
static void even_means(int n, double *A, double *b, double *row, double *column, double *work)
{
  double *by_row = work, *by_column = work + n;
  for (int round = 0; round < 2 * ROUNDS; round++) {
    for (int i = 0; i < n; i++) {
      by_row[i] = round % 2 == 0 ? mean_scale(n, A + i, (size_t)n) : 1;
      by_column[i] = round % 2 == 1 ? mean_scale(n, A + (size_t)i * (size_t)n, 1) : 1;
      row[i] *= by_row[i];
      column[i] *= by_column[i];
    }
    scale(n, A, b, by_row, by_column);
  }
}

/* Rows (i) and columns (n + j) that entries join to the one on the stack, all marked. Returns
 * the largest |b_i| among them. */
static double visit(int n, const double *A, const double *b, int *stack, int *mark, int start,
                    int *count)
{
  double most = 0;
  *count = 0;
  stack[(*count)++] = start;
  mark[start] = 1;
  for (int k = 0; k < *count; k++) {
    int node = stack[k], of_row = node < n;
    if (of_row) most = fmax(most, fabs(b[node]));
    const double *a = of_row ? A + node : A + (size_t)(node - n) * (size_t)n;
    for (int i = 0; i < n; i++) {
      int other = of_row ? n + i : i;
      if (a[(size_t)i * (of_row ? (size_t)n : 1)] == 0 || mark[other]) continue;
      mark[other] = 1;
      stack[(*count)++] = other;
    }
  }
  return most;
}

/* Blocks that no entry joins have no common scale but that of b: the largest b_i of each is brought
 * to the size of the largest. */
static void even_blocks(int n, const double *A, double *b, double *row, double *column, int *iwork)
{
  int *stack = iwork, *mark = iwork + 2 * n, count;
  double largest = 0;
  for (int i = 0; i < n; i++) largest = fmax(largest, fabs(b[i]));
  for (int i = 0; i < 2 * n; i++) mark[i] = 0;
  for (int start = 0; start < n; start++) {
    if (mark[start]) continue;
    double most = visit(n, A, b, stack, mark, start, &count);
    if (most == 0 || count == 1) continue;
    int shift = ilogb(largest) - ilogb(most);
    if (shift > FARTHEST) shift = FARTHEST;
    for (int k = 0; k < count; k++) {
      if (stack[k] < n) {
        b[stack[k]] = ldexp(b[stack[k]], shift);
        row[stack[k]] = ldexp(row[stack[k]], shift);
      } else {
        column[stack[k] - n] = ldexp(column[stack[k] - n], -shift);
      }
    }
  }
}

/* Then the largest entries (Ruiz, RAL-TR-2001-034): rows and columns by the root of their size,
 * until they are even. */
static void even_sizes(int n, double *A, double *b, double *row, double *column, double *work)
{
  double *by_row = work, *by_column = work + n;
  for (int round = 0; round < ROUNDS; round++) {
    measure(n, A, n, by_row, by_column);
    if (!uneven(n, by_row, EVEN) && !uneven(n, by_column, EVEN)) return;
    for (int i = 0; i < n; i++) {
      row[i] *= by_row[i] = root_scale(by_row[i]);
      column[i] *= by_column[i] = root_scale(by_column[i]);
    }
    scale(n, A, b, by_row, by_column);
  }
}

int nsdae_is_even(int n, const double *A, int lda, double *work)
{
  measure(n, A, lda, work, work + n);
  return !uneven(n, work, WORTH_IT) && !uneven(n, work + n, WORTH_IT);
}

void nsdae_equilibrate(int n, double *A, double *b, double *row, double *column, double *work,
                       int *iwork)
{
  for (int i = 0; i < n; i++) row[i] = column[i] = 1;
  if (nsdae_is_even(n, A, n, work)) return;
  even_means(n, A, b, row, column, work);
  even_sizes(n, A, b, row, column, work);
  even_blocks(n, A, b, row, column, iwork);
}
