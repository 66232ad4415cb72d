// Thread and workgroup number in a one-dimensional problem spread over rows of DISPATCH_WIDTH workgroups (see
// Dispatch::threads).
uint linear_group() { return gl_WorkGroupID.y * DISPATCH_WIDTH + gl_WorkGroupID.x; }

// A macro, because the size of a workgroup is only known after its layout has been declared: a function that is included
// before would take 1.
#define linear_thread() (gl_GlobalInvocationID.y * (DISPATCH_WIDTH * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x)
