// Instances of one rig in one dispatch: the workgroups of row y work for instance y. What instances have for themselves lies in
// equal parts of a buffer, one after the other; what they share is there once.
#ifndef DERMIS_INSTANCE
#define DERMIS_INSTANCE

// Where this instance's part begins in a buffer whose parts have this length.
uint part(uint length) {
    return gl_WorkGroupID.y * length;
}

// First word of a work list's head: workgroups for an indirect dispatch, in x the most that any instance needs, then the number
// of items of every instance.
uint head_of(uint row) {
    return row * (3u + gl_NumWorkGroups.y);
}

// The word that holds this instance's number of items.
uint count_at(uint row) {
    return head_of(row) + 3u + gl_WorkGroupID.y;
}

#endif
