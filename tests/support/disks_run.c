/* A trajectory of disks that fall (disks.h), for the tests of what reads such files, and to see
 * what one costs: bytes in all and per body and record, peak memory. usage: disks_run FILE.h5 DISKS
 * COLUMNS STEPS EVERY COMPRESS */
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "disks.h"

static nsdae_error error;

static int run(nsdae_system *system, const disks *d, char **argument)
{
  nsdae_sim *sim = NULL;
  nsdae_trajectory *t = NULL;
  nsdae_sim_options options;
  const nsdae_trajectory_info info = {
      .model = "disks", .every = atoi(argument[5]), .compress = atoi(argument[6])};
  double *start = calloc(6 * (size_t)d->n, sizeof *start);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = 1e-3;
  options.contact_tol = 1e-8;
  disks_start(d, start, start + 3 * d->n);
  int status = nsdae_sim_create(system, &options, &sim, &error);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, start, start + 3 * d->n);
  if (status == NSDAE_OK) status = nsdae_trajectory_create(sim, argument[1], &info, &t, &error);
  if (status == NSDAE_OK) {
    status = nsdae_sim_run(sim, atoi(argument[4]) * options.dt);
    if (status < 0) error = *nsdae_sim_error(sim);
  }
  nsdae_error at_end;
  int closed = nsdae_trajectory_close(&t, status, &at_end);
  if (status >= 0 && closed < 0) error = at_end;
  nsdae_sim_destroy(&sim);
  free(start);
  return status < 0 ? status : closed;
}

int main(int argc, char **argv)
{
  disks d;
  struct rusage usage;
  struct stat file;
  if (argc != 7) return 2;
  disks_create(&d, atoi(argv[2]), atoi(argv[3]));
  nsdae_system *system = disks_system(&d);
  int status = run(system, &d, argv);
  nsdae_system_destroy(&system);
  if (status < 0) fprintf(stderr, "%s\n", error.text);
  if (status == NSDAE_OK && stat(argv[1], &file) == 0 && getrusage(RUSAGE_SELF, &usage) == 0) {
    double records = atoi(argv[4]) / atoi(argv[5]) + 1;
    printf("%.0f bytes, %.1f a disk and record, peak memory %ld KiB\n", (double)file.st_size,
           (double)file.st_size / (d.n * records), usage.ru_maxrss);
  }
  disks_destroy(&d);
  return status < 0;
}
