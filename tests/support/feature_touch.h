/* The contact of one feature of a mechanism, all that its pair needs found for it alone. */
#ifndef TESTS_SUPPORT_FEATURE_TOUCH_H
#define TESTS_SUPPORT_FEATURE_TOUCH_H

#include "bodies_impl.h"
#include "narrow_phase.h"

/* What a feature needs of its solids, whose poses are given in its order. */
static inline void feature_meet(const nsdae_solid_of *solids, const nsdae_feature *f,
                                const nsdae_pose *pose, double reach, nsdae_meeting *met)
{
  int turned = nsdae_pair_is_turned(&solids[f->solid[0]], &solids[f->solid[1]]) ||
               (!f->edges && f->number != f->part[1]);
  nsdae_couple two;
  for (int i = 0; i < 2; i++) {
    int of = turned ? 1 - i : i;
    two.solid[i] = &solids[f->solid[of]];
    two.pose[i] = &pose[of];
  }
  nsdae_meet(&two, reach, met);
}

/* 0: another feature is nearer. */
static inline int feature_touch(const nsdae_solid_of *solids, const nsdae_feature *f,
                                const nsdae_pose *pose, nsdae_touch *touch)
{
  nsdae_meeting met;
  nsdae_closest closest;
  feature_meet(solids, f, pose, INFINITY, &met);
  if (!nsdae_feature_closest(f, &met, &closest)) return 0;
  const nsdae_couple two = nsdae_feature_couple(f, &met);
  *touch = nsdae_closest_touch(&closest, &two);
  return 1;
}

#endif
