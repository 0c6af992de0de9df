#include "phase.h"

#include <math.h>

enum { FEW = 2000, EACH = 64, MOST = FEW + 20 * EACH };

void nsdae_chattering_note(const nsdae_chattering *r, int contact, double t, double soon, int many)
{
  int *count = r->count + contact;
  if (!(t - r->last[contact] < soon))
    *count = 0;
  else
    *count = *count + many < MOST ? *count + many : MOST;
  r->last[contact] = t;
}

double nsdae_chattering_blur(const nsdae_chattering *r, int contact)
{
  return nsdae_chattering_growth(r->count[contact], FEW, EACH);
}

double nsdae_chattering_growth(int count, int few, double each)
{
  return exp2(fmin(fmax(count - few, 0) / each, 20));
}
