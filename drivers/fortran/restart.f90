! Going on where a trajectory ends, in it.
module pendulum_restart
  use nsdae
  use pendulum_probe
  implicit none
  private
  public :: restart_probe

  type :: attempt
    type(nsdae_sim) :: sim
    type(nsdae_trajectory_info) :: info
    type(nsdae_trajectory) :: trajectory
  end type

contains

  ! What nsdae_trajectory_resume will say to the file, should it come to an end there.
  integer(c_int) function restart_probe(sim, path, info, error) result(status)
    type(nsdae_sim), intent(in) :: sim
    character(len=*), intent(in) :: path
    type(nsdae_trajectory_info), intent(in) :: info
    type(nsdae_error), intent(inout) :: error
    type(attempt) :: first
    first%sim = sim
    first%info = info
    status = probe(path, try, first, error)
  end function

  ! Up to where the file would change by more than its status. user is the attempt.
  integer(c_int) function try(path, user, error) result(status)
    character(len=*), intent(in) :: path
    class(*), intent(inout) :: user
    type(nsdae_error), intent(inout) :: error
    status = NSDAE_E_STATE
    select type (user)
    type is (attempt)
      status = nsdae_trajectory_resume(user%sim, path, user%info, user%trajectory, error)
      if (status == NSDAE_OK) status = nsdae_trajectory_flush(user%trajectory, error)
    end select
  end function

end module
