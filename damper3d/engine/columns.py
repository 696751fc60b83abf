"""The columns of a sample, as the kernels number them."""

# The books and then the forces on the walls follow.
(
    TIME, DISPLACEMENT, VELOCITY, KINETIC, POTENTIAL, ELASTIC_NORMAL, ELASTIC_TANGENTIAL,
    CONTACTS_PP, CONTACTS_PW, IMPACT_PP, IMPACT_PW, POSITION_X, POSITION_Y, POSITION_Z,
    VELOCITY_X, VELOCITY_Y, VELOCITY_Z,
) = range(17)  # fmt: skip
N_COLUMNS = 17
