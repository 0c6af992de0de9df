/* The bodies of a scene file: see scene_file.c. */
#ifndef NSDAE_MODEL_SCENE_FILE_H
#define NSDAE_MODEL_SCENE_FILE_H

#include "driver.h"

typedef struct scene_file {
  char file[NSDAE_PARAM_TEXT_SIZE], sensors[NSDAE_PARAM_TEXT_SIZE];
  nsdae_scene scene;
  nsdae_bodies *world;
  double deepest, deepest_ever; /* penetration now, and the largest so far [m] */
  double raised;                /* energy that the projection added [J] */
  double impulse, given;        /* of the floor, and as it follows from the momentum [N s] */
  double momentum;              /* of all bodies along z at the start [N s] */
  double clock;                 /* CPU time of this thread at the last record [s] */
  double cpu, cpu_worst;        /* of all steps and of the worst [s] */
  long steps, worst;            /* number of steps, number of the worst */
} scene_file;

extern const driver_model scene_file_model;

#endif
