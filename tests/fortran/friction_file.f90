! Frictional contact problems in files: written, read, solved, refused.
program friction_file
  use, intrinsic :: iso_c_binding
  use nsdae
  use check
  implicit none
  character(len=*), parameter :: path = 'test_friction_file_f.h5'
  type(nsdae_friction_problem) :: problem
  type(nsdae_friction_file) :: file
  type(nsdae_error) :: error
  integer(c_int), target :: first(2) = [0, 1], block(1) = [0]
  real(c_double), target :: mu(1) = [0.5d0], q(3) = [-1d0, 0.25d0, 0d0]
  real(c_double), target :: W(9) = [2d0, 0d0, 0d0, 0d0, 2d0, 0d0, 0d0, 0d0, 2d0]
  real(c_double) :: r(3), u(3), low(3), short(2)
  integer(c_int) :: status

  problem%form = NSDAE_FRICTION_LOCAL
  problem%contacts = 1
  problem%mu => mu
  problem%w => q
  problem%first => first
  problem%block => block
  problem%value => W
  r = 0
  call is_int(nsdae_friction_solve(problem, r, u), NSDAE_OK, 'solved')
  status = nsdae_friction_write(path, problem, r=r, u=u, &
                                origin=nsdae_friction_origin(0.5d0, 7_c_long, 1d-9, 2, 'moreau'), error=error)
  if (status == NSDAE_E_UNSUPPORTED) stop
  call is_int(status, NSDAE_OK, 'written')
  call is_int(nsdae_friction_read(path, file, error), NSDAE_OK, 'read')
  call is_int(file%problem%contacts, 1, 'contacts')
  call is_true(all(file%problem%value == W), 'W')
  call is_true(all(file%problem%w == q) .and. all(file%problem%mu == mu), 'q and mu')
  call is_true(associated(file%r) .and. .not. associated(file%guess), 'points')
  call is_true(.not. associated(file%low), 'one part')
  call is_true(all(file%r == r), 'r')
  call is_true(file%tol == 1d-9 .and. file%refine == 2 .and. file%asymmetry == 0, 'tol')
  r = 0
  call is_int(nsdae_friction_solve(file%problem, r, u), NSDAE_OK, 'solved again')
  call is_true(all(r == file%r), 'the same bits')
  call nsdae_friction_file_release(file)
  call is_true(.not. associated(file%problem%value), 'released')
  call nsdae_friction_file_release(file)
  low = [1d-17, 2d-18, -3d-18]
  call is_int(nsdae_friction_write(path, problem, r=r, u=u, low=low), NSDAE_OK, 'written in two parts')
  call is_int(nsdae_friction_read(path, file, error), NSDAE_OK, 'read')
  call is_true(associated(file%low), 'two parts')
  call is_true(all(file%r == r) .and. all(file%low == low), 'r and low')
  call nsdae_friction_file_release(file)
  call is_true(.not. associated(file%low), 'released')
  short = 0
  call is_int(nsdae_friction_write(path, problem, guess=short, error=error), NSDAE_E_ARGUMENT, 'short')
  call is_text(trim(error%argument), 'r', 'argument')
  call is_int(nsdae_friction_write(path, problem, r=r, low=short, error=error), NSDAE_E_ARGUMENT, 'low')
  call contains_text(error%text, 'low', 'error%text')
  call is_int(nsdae_friction_read('/nonexistent', file, error), NSDAE_E_IO, 'no file')
  call is_true(index(error%text, 'nonexistent') > 0, 'its name')
  open (unit=9, file=path)
  close (9, status='delete')
  call check_done()
end program
