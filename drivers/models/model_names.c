#include "model_names.h"

void model_names(nsdae_system *system, int count, const model_name *names)
{
  int next[NSDAE_NAME_FRICTIONAL_JOINT + 1] = {0};
  for (int i = 0; i < count; i++)
    nsdae_system_set_name(system, names[i].kind, next[names[i].kind]++, names[i].name,
                          names[i].unit);
}
