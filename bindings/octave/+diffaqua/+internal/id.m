% SPDX-License-Identifier: MIT
% The handle of an object of a class; [] for [].
function number = id (name, object, class_name)
  if (isa (object, class_name))
    number = object.id;
  elseif (isnumeric (object) && isempty (object))
    number = [];
  else
    error ('diffaqua:DQA_ERROR_ARGUMENT', '%s: expected a %s, got %s', name, class_name, class (object));
  end
end
