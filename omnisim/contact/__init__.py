"""Contact in its own frame and in three stages, none of which imports a later one: tracking (where), kinematics (how
fast), reaction (what force). The paper calls it vertical separation."""
