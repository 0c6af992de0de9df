#include "sim_impl.h"

const nsdae_stepping *nsdae_stepping_of(int method)
{
  static const nsdae_stepping *const all[] = {
      [NSDAE_METHOD_IMPLICIT] = &nsdae_stepping_implicit,
      [NSDAE_METHOD_IMPLICIT_PRINTED] = &nsdae_stepping_printed,
      [NSDAE_METHOD_MOREAU] = &nsdae_stepping_moreau,
      [NSDAE_METHOD_PENALTY] = &nsdae_stepping_penalty,
      [NSDAE_METHOD_EVENT] = &nsdae_stepping_event,
  };
  if (method < 0 || method >= (int)(sizeof all / sizeof *all)) return NULL;
  return all[method];
}
