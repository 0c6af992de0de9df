#include "refusal.h"

#include <stddef.h>

static _Thread_local struct refusal {
  const void *handle; /* NULL: the last call was not refused */
  nsdae_error error;
} mine;

nsdae_error *nsdae_refusal_on(const void *handle)
{
  mine.handle = handle;
  return &mine.error;
}

const nsdae_error *nsdae_refusal_of(const void *handle)
{
  return mine.handle == handle ? &mine.error : NULL;
}

void nsdae_refusal_forget(const void *handle)
{
  if (mine.handle == handle) mine.handle = NULL;
}

const void *nsdae_this_thread(void)
{
  return &mine;
}
