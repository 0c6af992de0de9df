/* Writes a seeded problem in its global and its local form. usage: friction_sample GLOBAL LOCAL */
#include <nsdae/nsdae.h>
#include <stdio.h>

#include "friction_families.h"

int main(int argc, char **argv)
{
  friction_sample s;
  friction_local local;
  nsdae_error error = {0};
  if (argc != 3) return 2;
  friction_sample_draw(&s, FRICTION_SPHERES, 60, 2);
  friction_sample_local(&s, &local);
  int status = nsdae_friction_write(argv[1], &s.problem, NULL, NULL, &error);
  if (status == NSDAE_OK)
    status = nsdae_friction_write(argv[2], &local.problem, NULL, NULL, &error);
  if (status < 0) fprintf(stderr, "%s\n", error.text);
  friction_local_release(&local);
  friction_sample_release(&s);
  return status < 0;
}
