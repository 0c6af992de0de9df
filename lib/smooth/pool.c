#include "pool.h"

#include <nvector/nvector_serial.h>
#include <stdlib.h>

/* A serial vector's content, which SUNDIALS sees, and the pool behind it. */
typedef struct pooled {
  struct _N_VectorContent_Serial serial;
  nsdae_pool *pool;
  int kept, in_use; /* is the pool's; somebody's clone */
} pooled;

static void release(N_Vector vector)
{
  pooled *content = vector->content;
  if (content) {
    free(content->serial.data);
    free(content);
  }
  vector->content = NULL;
  N_VFreeEmpty(vector);
}

static void give_back(N_Vector vector)
{
  pooled *content = vector->content;
  content->in_use = 0;
  if (!content->kept) release(vector);
}

/* content of n entries for a vector whose operations are set */
static N_Vector furnish(N_Vector vector, nsdae_pool *pool, sunindextype n)
{
  pooled *content = calloc(1, sizeof *content);
  double *data = calloc((size_t)n + 1, sizeof *data);
  vector->content = content;
  if (!content || !data) {
    free(data);
    release(vector);
    return NULL;
  }
  content->serial.length = n;
  content->serial.own_data = SUNTRUE;
  content->serial.data = data;
  content->pool = pool;
  return vector;
}

static N_Vector make(N_Vector like, nsdae_pool *pool, sunindextype n)
{
  N_Vector vector = N_VNewEmpty(like->sunctx);
  if (!vector) return NULL;
  if (N_VCopyOps(like, vector) == 0) return furnish(vector, pool, n);
  N_VFreeEmpty(vector);
  return NULL;
}

static N_Vector duplicate(N_Vector like)
{
  const pooled *content = like->content;
  nsdae_pool *pool = content->pool;
  for (int i = 0; i < pool->count; i++) {
    pooled *spare = pool->kept[i]->content;
    if (spare->in_use) continue;
    spare->in_use = 1;
    return pool->kept[i];
  }
  return make(like, pool, content->serial.length);
}

N_Vector nsdae_pool_vector(nsdae_pool *pool, int n, SUNContext context)
{
  N_Vector serial = N_VNewEmpty_Serial(n, context);
  if (!serial) return NULL;
  N_Vector vector = make(serial, pool, n);
  N_VDestroy(serial);
  if (!vector) return NULL;
  vector->ops->nvclone = duplicate;
  vector->ops->nvdestroy = give_back;
  return vector;
}

int nsdae_pool_fill(nsdae_pool *pool, N_Vector like)
{
  const pooled *content = like->content;
  while (pool->count < NSDAE_POOL_MAX) {
    N_Vector made = make(like, pool, content->serial.length);
    if (!made) return -1;
    ((pooled *)made->content)->kept = 1;
    pool->kept[pool->count++] = made;
  }
  return 0;
}

void nsdae_pool_close(nsdae_pool *pool)
{
  while (pool->count > 0) release(pool->kept[--pool->count]);
}
