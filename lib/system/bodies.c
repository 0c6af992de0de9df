/* What trajectory files show of a system: copies of bodies, each with its points and texts behind
 * it in one piece of memory, which begins with the points. */
#include <stdlib.h>
#include <string.h>

#include "system_impl.h"

enum { TEXTS = 13 };

/* Gives the copy points and texts of its own; *owned is their memory. 0 where there is none. */
static int own(nsdae_body *copy)
{
  const char **text[TEXTS];
  size_t points = 3 * (size_t)copy->points * sizeof *copy->point, all = points;
  /* Where the texts of a body are: its name and formulas. */
  text[0] = &copy->name;
  text[1] = &copy->angle;
  for (int i = 0; i < 3; i++) {
    text[2 + i] = &copy->position[i];
    text[5 + i] = &copy->end[i];
  }
  for (int i = 0; i < 4; i++) text[8 + i] = &copy->quaternion[i];
  text[12] = &copy->colour;
  for (int i = 0; i < TEXTS; i++) all += *text[i] ? strlen(*text[i]) + 1 : 0;
  char *memory = malloc(all > 0 ? all : 1);
  if (!memory) return 0;
  if (points > 0) memcpy(memory, copy->point, points);
  copy->point = (const double *)memory;
  memory += points;
  for (int i = 0; i < TEXTS; i++) {
    if (!*text[i]) continue;
    size_t size = strlen(*text[i]) + 1;
    *text[i] = memcpy(memory, *text[i], size);
    memory += size;
  }
  return 1;
}

int nsdae_system_add_body(nsdae_system *system, const nsdae_body *body)
{
  if (!system) return NSDAE_E_ARGUMENT;
  if (!body || body->points < 0 || (body->points > 0 && !body->point))
    return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, "add_body", "body",
                               "body or its point is NULL, or its points are less than 0");
  int status = nsdae_system_open(system, "add_body");
  if (status < 0) return status;
  nsdae_body copy = *body, *more = system->body;
  /* Room for one more: doubled whenever their number is a power of two. */
  size_t n = (size_t)system->bodies;
  if ((n & (n - 1)) == 0) more = realloc(system->body, (n > 0 ? 2 * n : 1) * sizeof *more);
  if (more) system->body = more;
  if (!more || !own(&copy))
    return nsdae_system_refuse(system, NSDAE_E_MEMORY, "add_body", "", "out of memory");
  system->body[system->bodies++] = copy;
  return NSDAE_OK;
}

const nsdae_body *nsdae_system_get_bodies(const nsdae_system *system, int *n)
{
  if (n) *n = system ? system->bodies : 0;
  return system ? system->body : NULL;
}
