/* The crank-slider with friction in its slot: see crank_slider.c. */
#ifndef NSDAE_MODEL_CRANK_SLIDER_H
#define NSDAE_MODEL_CRANK_SLIDER_H

#include "driver.h"

typedef struct crank_slider {
  double L1, L2, m1, m2, m3, k, P0, w, g, mu;
} crank_slider;

extern const driver_model crank_slider_model;

#endif
