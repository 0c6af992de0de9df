#include "pose.h"

nsdae_pose nsdae_pose_ground(void)
{
  return (nsdae_pose){.R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
}

void nsdae_pose_place(int dimension, const double *q, nsdae_pose *pose)
{
  pose->r[0] = q[0];
  pose->r[1] = q[1];
  if (dimension == 2) {
    pose->angle = q[2];
    nsdae_rotation_planar(q[2], pose->R);
  } else {
    pose->r[2] = q[2];
    nsdae_rotation_spatial(q + 3, pose->R);
  }
}

void nsdae_pose_move(int dimension, const double *v, nsdae_pose *pose)
{
  for (int i = 0; i < dimension; i++) pose->v[i] = v[i];
  if (dimension == 2)
    pose->w[2] = v[2];
  else
    nsdae_turn(pose->R, v + 3, pose->w);
}

nsdae_pose nsdae_pose_of(int dimension, const double *q, const double *v)
{
  nsdae_pose pose = {.angle = 0};
  nsdae_pose_place(dimension, q, &pose);
  if (v) nsdae_pose_move(dimension, v, &pose);
  return pose;
}

nsdae_velocity_row nsdae_relative_row(const nsdae_pose pose[2], nsdae_jet3 x0, nsdae_jet3 x1,
                                      nsdae_jet3 n)
{
  const nsdae_jet3 x[2] = {x0, x1};
  nsdae_velocity_row row;
  for (int i = 0; i < 2; i++) {
    double arm[3], sign = i ? 1 : -1;
    for (int j = 0; j < 3; j++) {
      arm[j] = x[i].at[j].x - pose[i].r[j];
      row.linear[i][j] = sign * n.at[j].x;
    }
    nsdae_cross3(arm, row.linear[i], row.angular[i]); /* n . (w x arm) = w . (arm x n) */
  }
  return row;
}
