#include "callbacks.h"

#include <string.h>

#define IN_BRACKETS(...) __VA_ARGS__

#define CALL(name, type, of, arguments, ...)                                               \
  static int has_##name(const nsdae_system *s)                                             \
  {                                                                                        \
    return s->call.name != NULL;                                                           \
  }                                                                                        \
  static int call_##name(const nsdae_system *s, const nsdae_place *at, double *const *out, \
                         const int *ld)                                                    \
  {                                                                                        \
    (void)ld;                                                                              \
    return s->call.name(at->t, at->q, IN_BRACKETS arguments, s->user);                     \
  }

NSDAE_CALLBACKS(CALL)

#define COORDINATE       NSDAE_NAME_COORDINATE
#define VELOCITY         NSDAE_NAME_VELOCITY
#define CONSTRAINT       NSDAE_NAME_CONSTRAINT
#define CONTACT          NSDAE_NAME_CONTACT
#define FRICTIONAL_JOINT NSDAE_NAME_FRICTIONAL_JOINT

#define ENTRY(name, type, of, arguments, ...) {#name, has_##name, call_##name, __VA_ARGS__},

const nsdae_callback nsdae_callbacks[] = {NSDAE_CALLBACKS(ENTRY)};

const int nsdae_callbacks_count = (int)(sizeof nsdae_callbacks / sizeof *nsdae_callbacks);

const nsdae_callback *nsdae_callback_of(const char *name)
{
  for (int c = 0; c < nsdae_callbacks_count; c++)
    if (strcmp(nsdae_callbacks[c].name, name) == 0) return &nsdae_callbacks[c];
  return NULL;
}

int nsdae_output_extent(const nsdae_system *system, const nsdae_output *output, int kind)
{
  int each = kind < 0 ? 1 : nsdae_system_count(system, kind);
  return output->directions && kind == NSDAE_NAME_CONTACT ? each * system->dims.nt : each;
}
