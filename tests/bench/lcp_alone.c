/* No rival. */
#include <stddef.h>

#include "lcp_rival.h"

rival *rival_create(int n, double *A, double *b)
{
  (void)n;
  (void)A;
  (void)b;
  return NULL;
}

void rival_destroy(rival *r)
{
  (void)r;
}

int rival_solve(rival *r, double *x, double *y)
{
  (void)r;
  (void)x;
  (void)y;
  return -1;
}
